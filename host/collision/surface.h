// A triangle mesh to collide with, in its own frame: closest point with its sign, and segment crossings. Embree finds
// the candidates in float; the arithmetic on what it finds is in double.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "host/collision/embree.h"
#include "host/mesh.h"
#include "kernels/vec.h"

namespace malha {

using Point = Vector3<double>;

struct ClosestPoint {
  bool found = false;
  int triangle = -1;
  double distance = 0;    // m, >= 0
  Point q{};              // on the surface
  Point normal{};         // unit angle-weighted pseudonormal of the closest face, edge or corner
  bool boundary = false;  // on an edge or corner at the rim of an open mesh
};

struct Crossing {
  bool hit = false;
  Point q{};
  Point normal{};  // unit, of the face
};

class Surface {
 public:
  /// `mesh` has faces. Normals: Baerentzen, Aanaes 2005 ("Signed distance computation using the angle weighted
  /// pseudonormal"): by the closest feature they tell inside from outside without error, face normals do not.
  Surface(const Device& device, const Mesh& mesh);

  /// The nearest surface point within `radius` of a (both in the mesh's frame, m). A triangle that is known to be near
  /// makes the search short and changes nothing else.
  ClosestPoint closest(const Point& a, double radius, int known_near = -1) const;

  /// The first crossing on the way from a to b and `beyond` metres further. With front_only, crossings from behind a
  /// face do not count and do not hide what lies behind them. What passes a rim by less than a skin may count.
  Crossing crossing(const Point& a, const Point& b, double beyond, bool front_only) const;

  /// A lower bound of the distance of a: that of the bounding box; 0 inside it.
  double box_distance(const Point& a) const;
  double diagonal() const;
  int triangles() const { return static_cast<int>(triangles_.size()); }
  std::size_t bytes() const;

 private:
  /// The first crossing from `start` (relative to centre_) over `far` metres. The ray starts a skin earlier, since rays
  /// that start on a surface miss it half the time.
  Crossing along(const Point& start, const Point& direction, double far, bool front_only) const;

  std::vector<Point> points_;  // relative to centre_, so that float is fine wherever the mesh lies
  std::vector<Triangle> triangles_;
  std::vector<Point> face_normals_, corner_normals_;  // unit
  std::vector<std::array<Point, 3>> edge_normals_;    // unit; edge k joins corners k and k + 1
  std::vector<std::array<bool, 3>> rim_edges_;
  std::vector<bool> rim_corners_;
  Point centre_{}, half_{};
  double skin_ = 0;
  std::unique_ptr<TriangleScene> scene_;
};

}  // namespace malha
