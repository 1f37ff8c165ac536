// SPDX-License-Identifier: Apache-2.0
// Distances along a mesh from some of its points.
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Where the nearest source of each point is, and how far along the mesh.
struct Geodesics {
  std::vector<double> distance;  // m; infinite where no source can be reached
  std::vector<int> source;       // a point; -1 there
};

/// The shortest ways along edges, lines, diagonals of quads and straight across triangles(mesh), exact to rounding
/// (1e-9) on any mesh: windows through which the sources, and the points where ways turn, are seen straight (Chen and
/// Han, "Shortest paths on a polyhedron", 1990; Xin and Wang 2009). Windows that see the same place of the same plane
/// are joined: on flat meshes 5 a point, on a sphere of n points about sqrt(n), half a microsecond each.
Geodesics geodesics(const Mesh& mesh, const std::vector<int>& sources);

}  // namespace malha
