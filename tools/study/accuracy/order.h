// SPDX-License-Identifier: Apache-2.0
// Part of the study "accuracy": order of convergence of a hanging sheet over its substeps.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// The number of cells of order_of_convergence().
int order_cells(bool quick);

/// Compares a sheet of edges and both diagonals, pinned at a row and released from the horizontal, with the exact
/// motion of a chain of its rows (tools/study/reference/chain.h), by sweeps and by converged substeps.
Section order_of_convergence(Cells& cells, Json& rows);

}  // namespace malha::study
