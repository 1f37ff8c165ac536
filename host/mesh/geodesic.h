// SPDX-License-Identifier: Apache-2.0
// Geodesic distances on a mesh from a set of points.
#pragma once
#include <vector>

#include "host/mesh/rest_shape.h"

namespace malha {

/// The nearest source of each point and its geodesic distance.
struct Geodesics {
  std::vector<double> distance;  // m; infinite if no source is connected with the point
  std::vector<int> source;       // nearest source; -1 if there is none
};

/// Shortest paths along edges, lines, diagonals of quads and straight across triangles(mesh), exact up to rounding
/// (1e-9) on any mesh, by propagation of windows: parts of edges that straight paths from a source or a pseudo-source
/// cross (Chen and Han, "Shortest paths on a polyhedron", 1990; Xin and Wang 2009). Adjacent windows with the same
/// unfolded source are merged: flat meshes have 5 windows per point, a sphere of n points about sqrt(n), half a
/// microsecond each. Beyond a seam of the rest shape with sides of different lengths they are exact up to that
/// difference.
Geodesics geodesics(const RestShape& shape, const std::vector<int>& sources);

}  // namespace malha
