// SPDX-License-Identifier: Apache-2.0
// The edge-triangle intersection test agrees with their distance.
#include "host/model/edge_triangle_intersection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/mesh/vectors.h"
#include "kernels/geometry/closest_point.h"
#include "tests/numbers.h"

namespace malha {
namespace {

Vector3<double> to_vector(const Vec3& a) { return {a[0], a[1], a[2]}; }

double between_segments(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  const Vector3<double> d = to_vector(minus(q, p)), e = to_vector(minus(b, a)), from = to_vector(minus(a, p));
  const SegmentPoints<double> at = closest_on_segments(d, e, from);
  const Vector3<double> apart = from + e * at.t - d * at.s;
  return std::sqrt(dot(apart, apart));
}
double to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vector3<double> u = to_vector(minus(b, a)), v = to_vector(minus(c, a)), from = to_vector(minus(p, a));
  const Vector3<double> at = closest_on_triangle(u, v, from), apart = from - u * at.y - v * at.z;
  return std::sqrt(dot(apart, apart));
}

// Vertices are on a lattice of 3 x 3 x 3, so that most triples and pairs are degenerate in some way. Distances without
// contact are at least 1/30 there.
TEST(EdgeTriangleIntersection, IsFoundIffTheDistanceIsZero) {
  Random random(3);
  const auto place = [&] { return Vec3{double(random.below(3)), double(random.below(3)), double(random.below(3))}; };
  int touching = 0, crossing = 0, tried = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 p = place(), q = place(), a = place(), b = place(), c = place();
    const Vec3 n = cross(minus(b, a), minus(c, a));
    if (dot(n, n) == 0 || p == q) continue;
    const bool crossed = crosses(p, q, a, b, c);
    const double distance =
        crossed ? 0
                : std::min({to_triangle(p, a, b, c), to_triangle(q, a, b, c), between_segments(p, q, a, b),
                            between_segments(p, q, b, c), between_segments(p, q, c, a)});
    EXPECT_EQ(touches(p, q, a, b, c), distance < 0.01) << "case " << k << ", " << distance << " apart";
    ++tried, touching += distance < 0.01, crossing += crossed;
  }
  EXPECT_GT(crossing, 100);
  EXPECT_GT(touching, 3000);
  EXPECT_GT(tried - touching, 3000);
}

}  // namespace
}  // namespace malha
