// SPDX-License-Identifier: Apache-2.0
#include "host/environment/deforming_points.h"

#include "host/mesh/vectors.h"

namespace malha {

namespace {

Vec3 unit_or_zero(const Vec3& a) {
  const double length = norm(a);
  return length > 0 ? Vec3{a[0] / length, a[1] / length, a[2] / length} : Vec3{};
}

}  // namespace

DeformingPoints deforming_points(const EnvironmentMesh& object, const std::vector<Triangle>& triangles, double time) {
  DeformingPoints points;
  points.time = time, points.at = points_in_frame(object, time);
  std::vector<Vec3> sum(points.at.size(), Vec3{});
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      // Weighted by the sine of the triangle's angle.
      const Vec3 &a = points.at[t[k]], &b = points.at[t[(k + 1) % 3]], &c = points.at[t[(k + 2) % 3]];
      const Vec3 n = cross(unit_or_zero(minus(b, a)), unit_or_zero(minus(c, a)));
      for (int axis = 0; axis < 3; ++axis) sum[t[k]][axis] += n[axis];
    }
  points.normal.reserve(sum.size());
  for (const Vec3& n : sum) {
    const Vec3 unit = unit_or_zero(n);
    points.normal.push_back({unit[0], unit[1], unit[2], 0});
  }
  Vec3 mean{};
  for (const Vec3& x : points.at)
    for (int axis = 0; axis < 3; ++axis) mean[axis] += x[axis] / static_cast<double>(points.at.size());
  points.centre = {mean[0], mean[1], mean[2]};
  return points;
}

}  // namespace malha
