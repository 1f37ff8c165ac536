// SPDX-License-Identifier: Apache-2.0
// A mesh in the user's order: points, triangles and quads, lines for bodies without faces, and tetrahedra for
// volumetric bodies.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace malha {

using Vec3 = std::array<double, 3>;
using Edge = std::array<int, 2>;
using Triangle = std::array<int, 3>;
using Quad = std::array<int, 4>;         ///< corners; the last one of a triangle is -1
using Tetrahedron = std::array<int, 4>;  ///< of positive volume: (p1 - p0) . ((p2 - p0) x (p3 - p0)) > 0

/// Map from the vertices of a mesh file to the points of its mesh. All lists are empty where vertex i is point i.
struct FileVertices {
  std::vector<int> point;      ///< point of each vertex; -1: no face, line or tetrahedron uses the vertex
  std::vector<Vec3> position;  ///< of each vertex, m; empty where all vertices are used
  std::vector<Quad> faces;     ///< faces by vertex; empty if no vertices were merged, and for volumetric bodies
};

/// A part of a mesh file that names its parts: OBJ, or glTF, whose objects are nodes with a mesh.
struct MeshPart {
  std::string object;  ///< name; "": all objects
  std::string group;   ///< of OBJ, a name or a whole line of names; "": all groups
  explicit operator bool() const { return !object.empty() || !group.empty(); }
};

struct Mesh {
  std::vector<Vec3> points;  ///< m
  std::vector<Quad> faces;   ///< counter-clockwise seen from outside; with tetrahedra, their surface
  std::vector<Edge> lines;   ///< edges that belong to no face, as of chains
  std::vector<Tetrahedron> tetrahedra;
  FileVertices vertices{};
};

inline bool is_triangle(const Quad& face) { return face[3] < 0; }

}  // namespace malha
