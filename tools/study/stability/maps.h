// SPDX-License-Identifier: Apache-2.0
// Maps of the study "stability". Each function runs its trials, adds rows, and returns sections.
#pragma once
#include "tools/study/stability/map.h"

namespace malha::study {

/// Time step and stiffness, for malha's methods and other integrators.
Section steps_map(Cells& cells, Json& rows);

/// A weight at the end of a chain: mass ratio, and iterations or substeps.
Section masses_map(Cells& cells, Json& rows);

/// A hanging sheet: particles a side, and substeps.
Section resolution_map(Cells& cells, Json& rows);

/// The order in which a sweep projects constraints.
std::vector<Section> order_map(Cells& cells, Json& rows);

/// Growth of small motions about rest: by the order of the sweep, and for all kinds of constraints.
std::vector<Section> growth_of_motion(Cells& cells, Json& rows);

/// Conservation of energy and both momenta of a free body over a minute.
Section minute_in_vacuum(Cells& cells, Json& rows);

}  // namespace malha::study
