// SPDX-License-Identifier: Apache-2.0
// Independent check of intersections between deformable bodies and environment objects that name "edges": in double,
// without any code of the solver.
#pragma once
#include <cstdint>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Counts edges of bodies that properly cross triangles of such objects, and edges of these that cross triangles of
/// bodies, at x (solver's order, m) and `time` (s).
std::int64_t count_edge_crossings(const Model& model, const std::vector<Vec3>& x, double time);

/// Throws InputError for a model whose bodies cross such objects at the start: then no side is the inside.
void refuse_edge_crossings(const Model& model);

}  // namespace malha
