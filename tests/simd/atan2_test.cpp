// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "kernels/simd/elementary_functions.h"
#include "tests/numbers.h"

namespace malha {
namespace {

template <class R>
struct Arctangent2Of : testing::Test {
  /// |found - exact| in units of the last place of the exact angle, with a reference of more digits than R.
  static double error_in_ulp(R y, R x) {
    const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    const R rounded = static_cast<R>(std::fabs(exact));
    const R ulp = std::nextafter(rounded, std::numeric_limits<R>::infinity()) - rounded;
    return static_cast<double>(std::fabs(static_cast<long double>(arctangent2(y, x)) - exact) / ulp);
  }
};

using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Arctangent2Of, Reals);

TYPED_TEST(Arctangent2Of, IsWithinThreeUlpInAllQuadrantsAtAllSizes) {
  using R = TypeParam;
  Random random(1);
  double worst = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    const double angle = random(-std::numbers::pi, std::numbers::pi);
    // Sizes reach within a third of the type's range: squared areas may come as small and as large as this.
    const double size = std::pow(10.0, random(-1, 1) * std::numeric_limits<R>::max_exponent10 / 3.0);
    worst = std::max(worst, this->error_in_ulp(R(size * std::sin(angle)), R(size * std::cos(angle))));
  }
  EXPECT_LT(worst, 3);
}

TYPED_TEST(Arctangent2Of, IsWithinThreeUlpAroundTheSeamsOfItsApproximation) {
  using R = TypeParam;
  double worst = 0;
  for (const double seam : {0.66, 1.0, 1.0 / 2.41421356237309504880, 2.41421356237309504880})
    for (int k = -50; k <= 50; ++k)
      for (const R sign_y : {R(-1), R(1)})
        for (const R sign_x : {R(-1), R(1)}) {
          const R ratio = R(seam) * (R(1) + R(k) * std::numeric_limits<R>::epsilon());
          worst = std::max(worst, this->error_in_ulp(sign_y * ratio, sign_x));
        }
  EXPECT_LT(worst, 3);
}

TYPED_TEST(Arctangent2Of, IsWithinThreeUlpForTinyAndHugeRatios) {
  using R = TypeParam;
  double worst = 0;
  for (int exponent = 1; exponent < std::numeric_limits<R>::max_exponent10; ++exponent) {
    const R huge = R(std::pow(10.0, exponent));
    for (const R sign_y : {R(-1), R(1)})
      for (const R sign_x : {R(-1), R(1)}) {
        worst = std::max(worst, this->error_in_ulp(sign_y * huge, sign_x));
        // The angle itself is in the normal range: below it there are no ulp to speak of.
        if (exponent < -std::numeric_limits<R>::min_exponent10) {
          worst = std::max(worst, this->error_in_ulp(sign_y / huge, sign_x));
          worst = std::max(worst, this->error_in_ulp(sign_y, sign_x * huge));
        }
      }
  }
  EXPECT_LT(worst, 3);
}

TYPED_TEST(Arctangent2Of, IsExactOnTheAxes) {
  using R = TypeParam;
  const R pi = std::numbers::pi_v<R>;
  EXPECT_EQ(arctangent2(R(0), R(1)), R(0));
  EXPECT_EQ(arctangent2(R(1), R(0)), pi / 2);
  EXPECT_EQ(arctangent2(R(0), R(-1)), pi);
  EXPECT_EQ(arctangent2(R(-1), R(0)), -pi / 2);
  EXPECT_EQ(arctangent2(-R(0), R(-1)), pi) << "in (-pi, pi], whatever the sign of zero";
}

TYPED_TEST(Arctangent2Of, IsZeroWhereThereIsNoDirection) {
  using R = TypeParam;
  for (const R y : {R(0), -R(0)})
    for (const R x : {R(0), -R(0)}) EXPECT_EQ(arctangent2(y, x), R(0));
}

TYPED_TEST(Arctangent2Of, GivesPacksTheBitsOfScalars) {
  using R = TypeParam;
  Random random(2);
  for (int trial = 0; trial < 5000; ++trial) {
    Lane<R> y, x;
    std::array<R, kLanes<R>> ys, xs;
    for (int lane = 0; lane < kLanes<R>; ++lane) {
      ys[lane] = random.below(8) == 0 ? R(0) : R(random() * std::pow(10.0, random(-10, 10)));
      xs[lane] = random.below(8) == 0 ? R(0) : R(random() * std::pow(10.0, random(-10, 10)));
      y.v[lane] = ys[lane], x.v[lane] = xs[lane];
    }
    const Lane<R> angle = arctangent2(y, x);
    for (int lane = 0; lane < kLanes<R>; ++lane) {
      const R found = angle.v[lane], expected = arctangent2(ys[lane], xs[lane]);
      EXPECT_TRUE(same_bits(found, expected)) << ys[lane] << ", " << xs[lane];
    }
  }
}

}  // namespace
}  // namespace malha
