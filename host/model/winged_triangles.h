// SPDX-License-Identifier: Apache-2.0
// Triangles with their three neighbours, the elements of `plate` (kernels/constraints/plate.h).
#pragma once
#include <array>
#include <vector>

#include "malha/mesh.h"

namespace malha {

struct WingedTriangles {
  // The corners 0 .. 2 of each triangle; 3 + i is the far corner of the neighbour across from corner i.
  std::vector<std::array<int, 6>> list;
  /// Area of each triangle over the area that it represents: its own, and a share of that of nearby triangles that have
  /// fewer than three neighbours or whose six points do not determine a curvature. Triangles whose corners are all
  /// pinned do not bend.
  std::vector<double> softness;
  /// Hinges of the sides at which no winged triangle lies, in the form of hinges(mesh), and their softness: the area of
  /// both triangles over the edge's length^2. A hinge represents a third of both triangles.
  std::vector<std::array<int, 4>> hinges;
  std::vector<double> hinge_softness;
  int non_manifold = 0;  // number of edges with more than two triangles, which do not bend
};

/// The winged triangles of triangles(mesh). `pinned`: whether each point is pinned permanently.
WingedTriangles winged_triangles(const Mesh& mesh, const std::vector<bool>& pinned);

}  // namespace malha
