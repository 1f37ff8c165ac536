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

double distance_of(int first, const Vector3<double> (&x)[4]) {
  double weight[4];
  closest_weights(first, x, weight);
  return norm(closest_offset(x, weight));
}
double between_segments(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  return distance_of(2, {to_vector(p), to_vector(q), to_vector(a), to_vector(b)});
}
double to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  return distance_of(1, {to_vector(p), to_vector(a), to_vector(b), to_vector(c)});
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
