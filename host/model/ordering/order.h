// SPDX-License-Identifier: Apache-2.0
// The solver's order of particles: connected components one after the other, and neighbours close together in memory.
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Returns the user's indices in the solver's order: by component, and within a component in the user's order, unless
/// the Morton order of the positions (m) brings neighbours more than four times as close together. On a square grid
/// both are equally good, but only rows are contiguous; on a shuffled mesh the Morton order is better by a factor of
/// half the root of n. Sheets with long rows are cut into bands. `component` is that of each particle.
std::vector<int> solver_order(const std::vector<Vec3>& points, const std::vector<int>& component, int components,
                              const std::vector<Edge>& edges);

}  // namespace malha
