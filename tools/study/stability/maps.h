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

}  // namespace malha::study
