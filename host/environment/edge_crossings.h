// SPDX-License-Identifier: Apache-2.0
// What of deformable bodies crosses environment objects that name "edges": counted by itself, in double, with nothing
// of the solver's.
#pragma once
#include <cstdint>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Edges of bodies that properly cross triangles of such objects, and edges of these that cross triangles of bodies, at
/// x (solver's order, m) and `time` (s).
std::int64_t count_edge_crossings(const Model& model, const std::vector<Vec3>& x, double time);

/// Refuses a model whose bodies cross such objects at the start: then neither side is inside.
void refuse_edge_crossings(const Model& model);

}  // namespace malha
