// SPDX-License-Identifier: Apache-2.0
// Geometry of self-collision: closest points of primitives, prefix sums and radix sort.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "host/base/radix_sort.h"
#include "kernels/geometry/closest_point.h"
#include "tests/numbers.h"

namespace malha {
namespace {

template <class R>
Vector3<R> anywhere(Random& random, double size = 1) {
  return {R(random(-size, size)), R(random(-size, size)), R(random(-size, size))};
}

template <class R>
class ClosestPoints : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ClosestPoints, Precisions);

// The closest point q of a convex set is the one for which no point of the set lies beyond the plane through q with the
// normal p - q: a certificate that needs no other algorithm.
TYPED_TEST(ClosestPoints, OfATriangleHaveItsCornersBehindTheirPlane) {
  using R = TypeParam;
  Random random(1);
  const double rounding = sizeof(R) == 4 ? 2e-3 : 1e-7;  // needles keep half of the digits
  for (int k = 0; k < 20000; ++k) {
    const Vector3<R> b = anywhere<R>(random);
    Vector3<R> c = anywhere<R>(random);
    if (k % 5 == 1) c = b * R(random(-1, 2));  // no area
    if (k % 5 == 2) c = b;
    const Vector3<R> p = anywhere<R>(random), x[4] = {p, {0, 0, 0}, b, c};
    R w[4];
    weigh<PairKind::Face>(x, w);
    const Vector3<R> q = p - closest_offset(x, w);
    ASSERT_TRUE(w[0] == 1 && w[1] <= 0 && w[2] <= 0 && w[3] <= 0);
    ASSERT_NEAR(w[1] + w[2] + w[3], -1, 1e-6);
    for (const Vector3<R>& corner : {Vector3<R>{0, 0, 0}, b, c})
      ASSERT_LE(double(dot(p - q, corner - q)), rounding) << k;
  }
}

TYPED_TEST(ClosestPoints, OfTwoSegmentsHaveTheirEndsBehindTheirPlanes) {
  using R = TypeParam;
  Random random(2);
  const double rounding = sizeof(R) == 4 ? 5e-4 : 1e-10;  // nearly parallel ones lose half of the digits
  for (int k = 0; k < 20000; ++k) {
    Vector3<R> d = anywhere<R>(random), e = anywhere<R>(random);
    const Vector3<R> r = anywhere<R>(random);
    if (k % 5 == 1) e = d * R(random(-2, 2));  // parallel
    if (k % 5 == 2) d = {0, 0, 0};
    if (k % 5 == 3) e = {0, 0, 0};
    const Vector3<R> x[4] = {{0, 0, 0}, d, r, r + e};
    R w[4];
    weigh<PairKind::Edges>(x, w);
    ASSERT_TRUE(w[0] >= 0 && w[1] >= 0 && w[2] <= 0 && w[3] <= 0);
    ASSERT_NEAR(w[0] + w[1], 1, 1e-6);
    ASSERT_NEAR(w[2] + w[3], -1, 1e-6);
    const Vector3<R> apart = closest_offset(x, w), one = d * w[1], other = one - apart;
    for (const Vector3<R>& end : {Vector3<R>{0, 0, 0}, d}) ASSERT_GE(dot(apart, end - one), -rounding) << k;
    for (const Vector3<R>& end : {r, r + e}) ASSERT_LE(dot(apart, end - other), rounding) << k;
  }
}

TEST(RadixSort, SortsByKeyAndKeepsTheOrderOfEquals) {
  Random random(3);
  for (const int count : {0, 1, 2, 1000, 100000})
    for (const int bits : {3, 14}) {
      Sorter<OpenMP> sorter;
      std::vector<std::pair<unsigned, int>> expected;
      Keyed* const items = sorter.items(count);
      for (int i = 0; i < count; ++i) {
        items[i] = {unsigned(random.below(1 << bits)), i};
        expected.emplace_back(items[i].key, i);
      }
      std::sort(expected.begin(), expected.end());
      sorter.sort(OpenMP{3}, count, bits, 1 << bits);
      for (int i = 0; i < count; ++i) {
        ASSERT_EQ(sorter.sorted()[i].key, expected[i].first);
        ASSERT_EQ(sorter.sorted()[i].value, expected[i].second);
        ASSERT_LE(sorter.begin()[expected[i].first], i);
        ASSERT_GT(sorter.begin()[expected[i].first + 1], i);
      }
      EXPECT_EQ(sorter.begin()[0], 0);
      EXPECT_EQ(sorter.begin()[1 << bits], count);
    }
}

TEST(RadixSort, SumsWhatComesBefore) {
  Random random(4);
  for (const int count : {0, 1, 8191, 8192, 50000}) {
    std::vector<int> values(count), expected(count);
    for (int& value : values) value = random.below(9);
    std::exclusive_scan(values.begin(), values.end(), expected.begin(), 0);
    const int sum = std::accumulate(values.begin(), values.end(), 0);
    ScratchBuffer<OpenMP, int> memory;
    EXPECT_EQ(running_sum(OpenMP{2}, values.data(), count, memory), sum);
    EXPECT_EQ(values, expected);
  }
}

}  // namespace
}  // namespace malha
