// SPDX-License-Identifier: Apache-2.0
// Welding of vertices with equal or close positions, removal of unused vertices, and the map between the points that
// are left and the vertices of the file, for messages and frames.
#pragma once
#include <string>
#include <vector>

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

/// Marks the corners of faces, lines or tetrahedra.
template <class Items>
void mark_corners(const Items& items, std::vector<bool>& used) {
  for (const auto& item : items)
    for (const int corner : item)
      if (corner >= 0) used[corner] = true;
}

/// Removes vertices that no face, line or tetrahedron uses, unless all are unused. The others keep their order;
/// mesh.vertices keeps the numbering of the file. Returns the number of removed points.
int drop_unused_points(Mesh& mesh);

/// The point of each vertex of a mesh with this number of points: the vertices of the file (-1: unused), then the
/// points that tearing added.
std::vector<int> points_of_vertices(const FileVertices& file, int points);

/// The vertex of a point; the lowest one if several were merged.
int vertex_of(const FileVertices& file, int point);

}  // namespace malha
