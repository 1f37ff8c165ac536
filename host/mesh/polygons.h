// SPDX-License-Identifier: Apache-2.0
// Polygonal faces of mesh files and their triangulation.
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Finds two sides of a face that cross each other in the projection to its best-fit plane (Newell's normal). Returns
/// the corners at which they start, counted from 0, or {-1, -1}. Sides that only touch do not cross. Nor do opposite
/// sides of a twisted quad that are apart in space: either of its diagonals cuts it into triangles that meet only
/// there.
std::array<int, 2> crossing_sides(const std::vector<Vec3>& points, const std::vector<int>& corners);

/// Triangulates a face of three or more corners in its best-fit plane: as a fan from its first corner if that is valid,
/// otherwise by ear clipping, the best-shaped ears first. The triangles have the corners and the orientation of the
/// face, do not overlap, and have an area where the corners allow it; a corner on a straight side stays a corner. A
/// face without area becomes a fan. Returns an empty list if there is no triangulation, as for a face that crosses or
/// folds onto itself.
std::vector<Triangle> triangulate(const std::vector<Vec3>& points, const std::vector<int>& corners);

/// The faces of a mesh file as it has them: polygons of three or more corners, with the texture coordinates and names
/// that the file gives them. A list of attributes is empty where the file has none, or where they are not read.
struct Polygons {
  std::vector<int> begin{0};      // first corner of each polygon, then the number of corners
  std::vector<int> corners;       // vertices
  std::vector<std::size_t> line;  // of each polygon in its file, for messages; empty: the file has no lines

  std::vector<std::array<double, 2>> uv;  // texture coordinates
  std::vector<int> corner_uv;             // index of those of each corner; -1: none

  std::vector<std::string> objects, groups, materials;  // names
  std::vector<std::string> material_files;              // of OBJ, as its file names them
  std::vector<int> object, group, material;             // index of the name of each polygon; -1: none
  std::vector<int> line_object, line_group;             // of each line of the mesh
  std::vector<int> vertex_object;                       // object in whose part of the file a vertex is; -1: none

  std::size_t count() const { return begin.size() - 1; }
  std::span<const int> corners_of(std::size_t polygon) const {
    return std::span(corners).subspan(static_cast<std::size_t>(begin[polygon]),
                                      static_cast<std::size_t>(begin[polygon + 1] - begin[polygon]));
  }
  /// The index in `uv` of a corner's texture coordinates; -1: it has none.
  int uv_of(int corner) const { return corner_uv.empty() ? -1 : corner_uv[static_cast<std::size_t>(corner)]; }
  void add(std::span<const int> polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    begin.push_back(static_cast<int>(corners.size()));
  }
};

/// The faces as polygons.
Polygons polygons_of(const std::vector<Quad>& faces);

/// Appends the polygons to the faces of the mesh in their order: triangles and quads as they are, others triangulated.
/// Throws InputError for a polygon without a triangulation, with the file, the line and the number of the polygon.
/// `added`, if it is given, gets each of those faces in corners instead of points, counted over all polygons.
void add_faces(const Polygons& polygons, Mesh& mesh, const std::string& file, std::vector<Quad>* added = nullptr);

}  // namespace malha
