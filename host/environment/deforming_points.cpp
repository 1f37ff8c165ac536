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

void DeformingPoints::sample(const EnvironmentMesh& object, const std::vector<Triangle>& triangles, double at_time) {
  time = at_time;
  const std::vector<Vec3>& x = points_in_frame(object, at_time, at);
  normal.assign(x.size(), Vec4<double>{0, 0, 0, 0});
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      // Weighted by the sine of the triangle's angle.
      const Vec3 &a = x[t[k]], &b = x[t[(k + 1) % 3]], &c = x[t[(k + 2) % 3]];
      const Vec3 n = cross(unit_or_zero(minus(b, a)), unit_or_zero(minus(c, a)));
      Vec4<double>& sum = normal[t[k]];
      sum.x += n[0], sum.y += n[1], sum.z += n[2];
    }
  for (Vec4<double>& n : normal) {
    const Vec3 unit = unit_or_zero({n.x, n.y, n.z});
    n = {unit[0], unit[1], unit[2], 0};
  }
  Vec3 mean{};
  for (const Vec3& place : x)
    for (int axis = 0; axis < 3; ++axis) mean[axis] += place[axis] / static_cast<double>(x.size());
  centre = {mean[0], mean[1], mean[2]};
}

}  // namespace malha
