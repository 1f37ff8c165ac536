// SPDX-License-Identifier: Apache-2.0
// The maps of the study "stability". Each runs its trials, adds its rows, and says what they show.
#pragma once
#include "tools/study/stability/map.h"

namespace malha::study {

/// Time step and stiffness, for every method and for integrators that are not malha's.
Section steps_map(Cells& cells, Json& rows);

/// A weight at the end of a chain, by iterations and by substeps.
Section masses_map(Cells& cells, Json& rows);

/// Particles a side of a hanging sheet, by substeps.
Section resolution_map(Cells& cells, Json& rows);

/// In which order constraints are swept.
std::vector<Section> order_map(Cells& cells, Json& rows);

/// By how much a substep multiplies small motions about rest: by the order of the sweep, and of all kinds.
std::vector<Section> growth_of_motion(Cells& cells, Json& rows);

/// Energy and both momenta of a free body over a minute.
Section minute_in_vacuum(Cells& cells, Json& rows);

}  // namespace malha::study
