// SPDX-License-Identifier: Apache-2.0
// The solver's own order of the particles. Connected bodies lie one after the other, and neighbours close together.
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Returns user indices in the solver's order: by component, and within a component in the user's order, unless the
/// Morton order of the positions brings neighbours more than four times as close together. (On a square grid the two
/// are equally good, but only rows are contiguous; on a shuffled mesh Morton's is better by half the root of n.) Sheets
/// with long rows are cut into bands.
std::vector<int> solver_order(const std::vector<Vec3>& points, const std::vector<int>& component, int components,
                              const std::vector<Edge>& edges);

}  // namespace malha
