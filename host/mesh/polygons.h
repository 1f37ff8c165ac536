// SPDX-License-Identifier: Apache-2.0
// Faces of meshes as files list them, with any number of corners, and their triangulation.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Whether two sides of a face cross each other, seen along the normal of its best plane (Newell's): those from these
/// corners to the next, counted from 0; {-1, -1}: none do. Sides that only touch do not cross. Nor do those of a
/// twisted quad that pass each other in space: either of its diagonals cuts it into triangles that meet there alone.
std::array<int, 2> crossing_sides(const std::vector<Vec3>& points, const std::vector<int>& corners);

/// Triangulates a face of three or more corners in its best plane: a fan from its first corner where that is valid,
/// otherwise by ear clipping, the best-shaped ears first. The triangles have the face's corners and orientation, do not
/// overlap, and have an area where the corners allow it: a corner on a straight side stays a corner. A face without an
/// area becomes a fan. Empty where there is no triangulation, as in a face that crosses or folds onto itself.
std::vector<Triangle> triangulate(const std::vector<Vec3>& points, const std::vector<int>& corners);

/// The faces of a file, kept until all points are known: a face may name points that come after it.
class PolygonList {
 public:
  void reserve(std::size_t faces) { faces_.reserve(faces); }
  /// A face of three or more corners. `line`: the line of the file on which it stands; 0: the file has no lines.
  void add(const std::vector<int>& corners, std::size_t line);
  /// Appends all faces to the mesh in their order: triangles and quads as they are, others as triangles. Refuses a face
  /// without a triangulation by its file, line and number.
  void append_to(Mesh& mesh, const std::string& file) const;

 private:
  struct Face {
    std::size_t line;
    int corners;
  };
  std::vector<Face> faces_;
  std::vector<int> corners_;  // of all faces
};

}  // namespace malha
