// SPDX-License-Identifier: Apache-2.0
// A mesh as the user gave it: points in the user's order, triangles and quads, lines for bodies without faces, and
// tetrahedra for bodies that are full.
#pragma once
#include <array>
#include <vector>

namespace malha {

using Vec3 = std::array<double, 3>;
using Edge = std::array<int, 2>;
using Triangle = std::array<int, 3>;
using Quad = std::array<int, 4>;         ///< a triangle has -1 in its last place
using Tetrahedron = std::array<int, 4>;  ///< of positive volume: (p1 - p0) . ((p2 - p0) x (p3 - p0)) > 0

/// What became of the vertices of a mesh's file. All empty where vertex i is point i.
struct FileVertices {
  std::vector<int> point;   ///< that each became; -1: nothing uses it
  std::vector<Vec3> place;  ///< of each, m; empty where all are used
  std::vector<Quad> faces;  ///< the mesh's faces by the file's vertices; empty where none were merged, or full bodies'
};

struct Mesh {
  std::vector<Vec3> points;  ///< m
  std::vector<Quad> faces;   ///< counter-clockwise seen from outside; where there are tetrahedra, their surface
  std::vector<Edge> lines;   ///< edges that belong to no face (chains)
  std::vector<Tetrahedron> tetrahedra;
  FileVertices vertices{};
};

inline bool is_triangle(const Quad& face) { return face[3] < 0; }

}  // namespace malha
