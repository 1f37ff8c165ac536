// SPDX-License-Identifier: Apache-2.0
#include "host/attachments/surface_points.h"

#include <cmath>
#include <map>
#include <utility>

#include "host/mesh/closest_of_triangles.h"
#include "host/mesh/topology.h"

namespace malha {

namespace {

Vector3<double> vector(const Vec3& x) { return {x[0], x[1], x[2]}; }

/// Axes of a triangle: along its first edge, across it in the plane, and along the normal.
struct TriangleAxes {
  Vector3<double> along, across, normal;
};

/// Returns false for a triangle without area.
bool axes_of(const Vector3<double>& b, const Vector3<double>& c, TriangleAxes& axes) {
  const Vector3<double> n = cross(b, c);
  const double area = norm(n);
  if (!(area > 1e-12 * norm(b) * norm(c))) return false;
  axes.along = b * (1 / norm(b)), axes.normal = n * (1 / area);
  axes.across = cross(axes.normal, axes.along);
  return true;
}

}  // namespace

SurfacePoints::Followed SurfacePoints::follow(const EnvironmentMesh& object,
                                              const std::vector<Vector3<double>>& places) {
  const Pose start = pose_at(object.spec.motion, 0);
  std::vector<Vec3> x;
  for (const Vec3& point : object.mesh.points) {
    const Vector3<double> at = to_world(start, vector(point));
    x.push_back({at.x, at.y, at.z});
  }
  const auto axes = [&](const Triangle& t, TriangleAxes& of) {
    const Vector3<double> a = vector(x[t[0]]);
    return axes_of(vector(x[t[1]]) - a, vector(x[t[2]]) - a, of);
  };
  std::vector<Triangle> triangles = malha::triangles(object.mesh);
  TriangleAxes of;
  std::erase_if(triangles, [&](const Triangle& t) { return !axes(t, of); });

  Followed all;
  std::map<int, std::size_t> number;  // of a vertex of the object, among those that are needed
  for (const Vector3<double>& p : places) {
    const ClosestOfTriangles closest = closest_of_triangles(triangles, x, p);
    const Triangle& triangle = triangles[closest.triangle];
    axes(triangle, of);
    const auto along = [&](const Vector3<double>& axis) { return dot(axis, closest.offset); };
    Point point{{}, closest.wb, closest.wc, {along(of.along), along(of.across), along(of.normal)}};
    for (std::size_t k = 0; k < 3; ++k) {
      const int vertex = triangle[k];
      const auto [known, added] = number.try_emplace(vertex, all.vertices.size());
      if (added) all.vertices.push_back(vertex);
      point.corner[k] = known->second;
    }
    all.points.push_back(point);
  }
  return all;
}

SurfacePoints::SurfacePoints(const EnvironmentMesh& object, const std::vector<Vector3<double>>& places)
    : SurfacePoints(object, follow(object, places)) {}
SurfacePoints::SurfacePoints(const EnvironmentMesh& object, Followed followed)
    : vertices_(object, followed.vertices), points_(std::move(followed.points)) {
  at_.reserve(points_.size());
}

const std::vector<Vector3<double>>& SurfacePoints::at(double time) {
  const std::vector<Vec3>& x = vertices_.at(time);
  at_.clear();
  for (const Point& point : points_) {
    const Vector3<double> a = vector(x[point.corner[0]]), b = vector(x[point.corner[1]]) - a,
                          c = vector(x[point.corner[2]]) - a, &offset = point.offset;
    Vector3<double> place = a + b * point.wb + c * point.wc;
    if (TriangleAxes axes; axes_of(b, c, axes))  // a triangle that has lost its area has no direction
      place = place + axes.along * offset.x + axes.across * offset.y + axes.normal * offset.z;
    at_.push_back(place);
  }
  return at_;
}

}  // namespace malha
