// SPDX-License-Identifier: Apache-2.0
// Triangles with the three about them, on which `plate` stands (kernels/constraints/plate.h).
#pragma once
#include <array>
#include <vector>

#include "malha/mesh.h"

namespace malha {

struct WingedTriangles {
  std::vector<std::array<int, 6>> list;  // corners, and 3 + i beyond the side across from corner i
  /// Each one's own area over the area that it stands for: its own, and its part of that of the triangles about it that
  /// have no three neighbours, or whose six points fix no curvature. What is held at all three corners does not bend.
  std::vector<double> softness;
  /// What none of them has, as hinges(mesh), and of each the area of both triangles over the edge's length^2. A hinge
  /// stands for a third of both.
  std::vector<std::array<int, 4>> hinges;
  std::vector<double> hinge_softness;
  int crowded = 0;  // edges of more than two triangles, where nothing bends
};

/// Of triangles(mesh). `held`: of each point, for good.
WingedTriangles winged_triangles(const Mesh& mesh, const std::vector<bool>& held);

}  // namespace malha
