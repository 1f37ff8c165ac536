// SPDX-License-Identifier: Apache-2.0
// Of the study "accuracy": how the error of a hung sheet falls with the substeps.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// How many cells that makes.
int order_cells(bool quick);

/// A sheet of edges and both diagonals that hangs by a row, let go from the horizontal, against the exact motion of a
/// chain of its rows (tools/study/reference/chain.h), by sweeps and by converged substeps.
Section order_of_convergence(Cells& cells, Json& rows);

}  // namespace malha::study
