// SPDX-License-Identifier: Apache-2.0
// The logarithm of scalars and packs.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kernels/simd/elementary_functions.h"

namespace malha {
namespace {

template <class R>
double ulps(R found, double expected) {
  const R size = std::abs(R(expected));
  const double ulp = double(std::nextafter(size, std::numeric_limits<R>::infinity())) - double(size);
  return std::abs(double(found) - expected) / ulp;
}

TEST(Logarithm, IsTheLibrarysToTwoUlps) {
  for (double power = -300; power < 300; power += 0.0137)
    EXPECT_LT(ulps(logarithm(std::pow(10, power)), std::log(std::pow(10, power))), 2) << power;
  for (int i = 1; i <= 20000; ++i) {  // about 1, where it is small
    const double a = 0.25 + i * 2e-4;
    EXPECT_LT(ulps(logarithm(a), std::log(a)), 2) << a;
    const float b = float(a);
    EXPECT_LT(ulps(logarithm(b), std::log(double(b))), 2) << b;
  }
  EXPECT_EQ(logarithm(1.0), 0);
  EXPECT_EQ(logarithm(1.0f), 0);
}

TEST(Logarithm, IsFiniteOfWhatHasNone) {
  for (const double a : {0.0, -1.0, -1e300})
    EXPECT_NEAR(logarithm(a), std::log(std::numeric_limits<double>::min()), 1e-10);
  EXPECT_NEAR(logarithm(0.0f), std::log(std::numeric_limits<float>::min()), 1e-4);
}

template <class R>
void expect_lanes_alike() {
  for (int first = 0; first < 1000; ++first) {
    Lane<R> pack;
    for (int i = 0; i < kLanes<R>; ++i) set_lane(pack, i, R(0.01) * R(1 + first * kLanes<R> + i));
    const Lane<R> all = logarithm(pack);
    for (int i = 0; i < kLanes<R>; ++i) EXPECT_EQ(lane(all, i), logarithm(lane(pack, i)));
  }
}
TEST(Logarithm, OfAPackIsThatOfItsLanes) {
  expect_lanes_alike<float>();
  expect_lanes_alike<double>();
}

}  // namespace
}  // namespace malha
