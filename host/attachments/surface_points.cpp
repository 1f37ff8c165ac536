// SPDX-License-Identifier: Apache-2.0
#include "host/attachments/surface_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "host/mesh/topology.h"
#include "kernels/geometry/closest_point.h"

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

/// A lower bound of the squared distance of a triangle from p.
double box_distance2(const Vector3<double>& p, const Vector3<double> (&x)[3]) {
  const auto out = [](double at, double a, double b, double c) {
    return std::max({std::min({a, b, c}) - at, at - std::max({a, b, c}), 0.0});
  };
  const double dx = out(p.x, x[0].x, x[1].x, x[2].x), dy = out(p.y, x[0].y, x[1].y, x[2].y),
               dz = out(p.z, x[0].z, x[1].z, x[2].z);
  return dx * dx + dy * dy + dz * dz;
}

}  // namespace

SurfacePoints::Followed SurfacePoints::follow(const EnvironmentMesh& object,
                                              const std::vector<Vector3<double>>& places) {
  const std::vector<Triangle> triangles = malha::triangles(object.mesh);
  const Pose start = pose_at(object.spec.motion, 0);
  std::vector<Vector3<double>> x;
  for (const Vec3& point : object.mesh.points) x.push_back(to_world(start, vector(point)));

  Followed all;
  std::map<int, std::size_t> number;  // of a vertex of the object, among those that are needed
  for (const Vector3<double>& p : places) {
    double least = std::numeric_limits<double>::infinity();
    Point point;
    const Triangle* closest = nullptr;
    for (const Triangle& t : triangles) {
      const auto at = [&](std::size_t k) { return x[static_cast<std::size_t>(t[k])]; };
      const Vector3<double> corner[3]{at(0), at(1), at(2)};
      if (box_distance2(p, corner) >= least) continue;
      const Vector3<double> b = corner[1] - corner[0], c = corner[2] - corner[0];
      TriangleAxes axes;
      if (!axes_of(b, c, axes)) continue;
      const Vector3<double> weights = closest_on_triangle(b, c, p - corner[0]),
                            offset = p - corner[0] - b * weights.y - c * weights.z;
      if (dot(offset, offset) >= least) continue;
      least = dot(offset, offset), closest = &t;
      point.wb = weights.y, point.wc = weights.z;
      point.offset = {dot(axes.along, offset), dot(axes.across, offset), dot(axes.normal, offset)};
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const int vertex = (*closest)[k];
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
    : vertices_(object, followed.vertices), points_(std::move(followed.points)) {}

std::vector<Vector3<double>> SurfacePoints::at(double time) const {
  const std::vector<Vec3> x = vertices_.at(time);
  std::vector<Vector3<double>> all;
  all.reserve(points_.size());
  for (const Point& point : points_) {
    const Vector3<double> a = vector(x[point.corner[0]]), b = vector(x[point.corner[1]]) - a,
                          c = vector(x[point.corner[2]]) - a, &offset = point.offset;
    Vector3<double> place = a + b * point.wb + c * point.wc;
    if (TriangleAxes axes; axes_of(b, c, axes))  // a triangle that has lost its area has no direction
      place = place + axes.along * offset.x + axes.across * offset.y + axes.normal * offset.z;
    all.push_back(place);
  }
  return all;
}

}  // namespace malha
