// SPDX-License-Identifier: Apache-2.0
// Welding of vertices with equal or close positions, and removal of unused vertices.
#pragma once
#include <string>

#include "malha/mesh.h"

namespace malha {

struct Welded {
  int merged = 0;   // number of vertices merged into another one
  int removed = 0;  // number of faces and lines with less than three, or two, distinct corners left
};

/// Merges clusters of vertices, in which each is within `distance` (m, >= 0; 0: exactly equal positions) of another
/// one, into their lowest vertex. The remaining vertices are farther apart than that, and the clusters do not depend on
/// the order. Corners that coincide are removed, and with them degenerate faces and lines. It takes nearly linear time.
/// mesh.vertices keeps the numbering of the file. Throws InputError, which names `file`, for tetrahedra that would
/// become degenerate.
Welded weld(Mesh& mesh, double distance, const std::string& file);

/// Removes vertices that no face, line or tetrahedron uses, unless all are unused. The others keep their order;
/// mesh.vertices keeps the numbering of the file. Returns the number of removed points.
int drop_unused_points(Mesh& mesh);

}  // namespace malha
