// SPDX-License-Identifier: Apache-2.0
// Study "scaling": how much faster more threads are, on the same body (strong) and on one that grows with them (weak).
#pragma once
#include <string>

#include "tools/study/cloth_methods.h"
#include "tools/study/study.h"

namespace malha::study {

Findings run_scaling(Cells& cells);

/// The rows of a cell (see scaling_cell), one a number of threads, with what each is worth beside one thread; one row
/// with why where it was left out. `kind`: "strong" or "weak"; `side`: particles, of one thread's body.
Json scaling_rows(const std::string& kind, const ClothMethod& method, int side, const Json& cell);

}  // namespace malha::study
