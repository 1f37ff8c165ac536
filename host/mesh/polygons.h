// SPDX-License-Identifier: Apache-2.0
// Polygonal faces of mesh files and their triangulation.
#pragma once
#include <array>
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

/// The faces of a file. They are stored until all points are known, since a face may precede its points in the file.
class PolygonList {
 public:
  void reserve(std::size_t faces) { faces_.reserve(faces); }
  /// Adds a face of three or more corners. `line` is its line in the file; 0: the file has no lines.
  void add(const std::vector<int>& corners, std::size_t line);
  /// Appends all faces to the mesh in their order: triangles and quads as they are, others triangulated. Throws
  /// InputError for a face without a triangulation, with the file, the line and the number of the face. `added`, if it
  /// is given, gets each of those faces in corners instead of points, counted over all faces that were added here.
  void append_to(Mesh& mesh, const std::string& file, std::vector<Quad>* added = nullptr) const;

 private:
  struct Face {
    std::size_t line;
    int corners;
  };
  std::vector<Face> faces_;
  std::vector<int> corners_;  // of all faces, one after the other
};

}  // namespace malha
