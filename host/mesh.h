// A mesh as the user gave it: points in the user's order, triangles and quads, lines for bodies without faces, and
// tetrahedra for bodies that are full.
#pragma once
#include <array>
#include <vector>

namespace malha {

using Vec3 = std::array<double, 3>;
using Edge = std::array<int, 2>;
using Triangle = std::array<int, 3>;
using Quad = std::array<int, 4>;         // a triangle has -1 in its last place
using Tetrahedron = std::array<int, 4>;  // of positive volume: (p1 - p0) . ((p2 - p0) x (p3 - p0)) > 0

struct Mesh {
  std::vector<Vec3> points;  // m
  std::vector<Quad> faces;   // counter-clockwise seen from outside; where there are tetrahedra, their surface
  std::vector<Edge> lines;   // edges that belong to no face (chains)
  std::vector<Tetrahedron> tetrahedra;
};

inline bool is_triangle(const Quad& face) { return face[3] < 0; }

}  // namespace malha
