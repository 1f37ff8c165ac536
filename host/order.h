// The solver's own order of the particles. Connected bodies lie one after the other, and neighbours close together.
#pragma once
#include <vector>

#include "host/mesh.h"

namespace malha {

/// Returns user indices in the solver's order: by component, and within a component in the user's order where that
/// keeps neighbours at least as close together as the Morton order of the positions would, else in Morton order.
std::vector<int> solver_order(const std::vector<Vec3>& points, const std::vector<int>& component, int components,
                              const std::vector<Edge>& edges);

}  // namespace malha
