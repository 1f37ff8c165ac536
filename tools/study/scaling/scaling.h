// SPDX-License-Identifier: Apache-2.0
// Study "scaling": speed-up by more threads, on the same body (strong) and on one that grows with them (weak).
#pragma once
#include <string>

#include "tools/study/cloth_methods.h"
#include "tools/study/study.h"

namespace malha::study {

Findings run_scaling(Cells& cells);

/// The rows of a cell (see scaling_cell), one for each number of threads, with its speed-up over one thread; a single
/// row with the reason if the case was left out. `kind`: "strong" or "weak"; `side`: of one thread's body, in
/// particles.
Json scaling_rows(const std::string& kind, const ClothMethod& method, int side, const Json& cell);

}  // namespace malha::study
