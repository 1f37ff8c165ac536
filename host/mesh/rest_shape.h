// SPDX-License-Identifier: Apache-2.0
// The rest shape of a mesh: where the corners of an edge, a triangle, a hinge ... lie when nothing strains them.
// Without a rest mesh of its own that is where the points are. A rest mesh may have seams: a point then has several
// places, one for each piece of the pattern that it joins. An edge at which the rest mesh lies folded onto itself
// counts as a seam too, if the mesh has any.
#pragma once
#include <memory>
#include <vector>

#include "host/mesh/compressed_lists.h"
#include "kernels/projection/element.h"
#include "malha/mesh.h"

namespace malha {

/// A view of a mesh and of its rest mesh, which must outlive it.
class RestShape {
 public:
  /// The points of the mesh are at rest.
  RestShape(const Mesh& mesh) : RestShape(mesh, nullptr) {}
  /// `rest` has the faces of the mesh in their order, with the numbers of its own points. Without seams its points,
  /// faces and lines are numbered as those of the mesh. Null: the points of the mesh are at rest.
  RestShape(const Mesh& mesh, const Mesh* rest);

  const Mesh& mesh() const { return *mesh_; }
  /// The places of the faces' corners: of the rest mesh, or the mesh itself.
  const Mesh& places() const { return *places_; }
  bool has_seams() const { return faces_ != nullptr; }

  /// Computes the rest positions (m) of the corners of an element, whose points are given in the order of its kind. A
  /// neighbour beyond a seam lies in the plane of the triangle, unfolded about the common edge; the triangles on both
  /// sides keep their sizes. An edge of a seam has the mean of its lengths on both sides.
  void corners(Element element, const int* points, Vec3* X) const;

  double length(int a, int b) const;          ///< m
  double squared_length(int a, int b) const;  ///< m^2
  /// The area of three points of one face, m^2.
  double area(int a, int b, int c) const;

 private:
  const Vec3& place(int point) const { return places_->points[point]; }
  /// Computes the places of three points in the face that has them all.
  void triangle(int a, int b, int c, Vec3 (&X)[3]) const;
  void edge(int a, int b, Vec3 (&X)[2]) const;
  /// The place of a wing beyond the edge from[0] to from[1], whose places in the triangle are `own`; own[2] is the
  /// triangle's third corner.
  Vec3 wing(const int (&from)[2], int point, const Vec3 (&own)[3]) const;

  const Mesh* mesh_;
  const Mesh* places_;
  std::shared_ptr<const CompressedLists<int>> faces_;  // of each point; null without seams
};

/// Lengths at both sides of the seams of a rest mesh that differ (ease), as a part of the shorter one.
struct Ease {
  double most = 0;
  Edge at{-1, -1};  // points of the mesh
};
Ease largest_ease(const RestShape& shape);

}  // namespace malha
