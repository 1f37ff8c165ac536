// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/closest_of_triangles.h"

#include <algorithm>
#include <limits>

#include "kernels/geometry/closest_point.h"

namespace malha {

namespace {

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

ClosestOfTriangles closest_of_triangles(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x,
                                        const Vector3<double>& p) {
  ClosestOfTriangles closest{};
  double least2 = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto at = [&](std::size_t k) {
      const Vec3& point = x[static_cast<std::size_t>(triangles[t][k])];
      return Vector3<double>{point[0], point[1], point[2]};
    };
    const Vector3<double> corner[3]{at(0), at(1), at(2)};
    if (box_distance2(p, corner) >= least2) continue;
    const Vector3<double> b = corner[1] - corner[0], c = corner[2] - corner[0];
    const Vector3<double> weights = closest_on_triangle(b, c, p - corner[0]),
                          offset = p - corner[0] - b * weights.y - c * weights.z;
    if (dot(offset, offset) >= least2) continue;
    least2 = dot(offset, offset), closest = {t, weights.y, weights.z, offset};
  }
  return closest;
}

}  // namespace malha
