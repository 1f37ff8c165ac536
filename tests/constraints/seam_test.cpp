// SPDX-License-Identifier: Apache-2.0
#include "kernels/constraints/seam.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/projection/one_constraint.h"

namespace malha {
namespace {

TEST(SurfaceAttachment, RestsAtThePointOfTheTriangleThatIsClosest) {
  const Vector3<double> a{0, 0, 0}, b{2, 0, 0}, c{0, 0, 4};
  struct Case {
    Vector3<double> p;
    double gap, second, third;
  };
  for (const Case& one : {Case{{0.5, 0.3, 1}, 0.3, 0.25, 0.25},  // above the inside
                          Case{{1, 0.4, -0.3}, 0.5, 0.5, 0},     // beyond an edge
                          Case{{3, 0, 0}, 1, 1, 0},              // beyond a corner
                          Case{{0, 0, 1}, 0, 0, 0.25}}) {        // on it
    const Rest<SurfaceAttachment> rest = rest_of<SurfaceAttachment>({one.p, a, b, c}, 1);
    EXPECT_NEAR(rest[0], one.gap, 1e-15);
    EXPECT_NEAR(rest[1], one.second, 1e-15);
    EXPECT_NEAR(rest[2], one.third, 1e-15);
  }
}

TEST(SurfaceAttachment, DrawsTheParticleAndItsPointTogetherByTheirMasses) {
  // A particle of 1 kg, 1 m above the middle of a triangle of 3 kg: three quarters of the way are the particle's.
  Rest<SurfaceAttachment> rest;
  rest[1] = rest[2] = 1.0 / 3;
  OneConstraint<SurfaceAttachment, double> one({{{1, 1, 1}, {0, 0, 0}, {3, 0, 0}, {0, 0, 3}}}, {1, 1, 1, 1}, rest);
  one.project<Update::Stiff>(1, 0);
  EXPECT_NEAR(one.p(0).y, 0.25, 1e-15);
  for (int j = 1; j < 4; ++j) EXPECT_NEAR(one.p(j).y, 0.25, 1e-15);
  EXPECT_NEAR(one.C(), 0, 1e-15);
}

TEST(ClosingFactor, FallsFromOneToZeroAndStaysThere) {
  EXPECT_EQ(closing_factor(2.0, 0.0), 1);
  EXPECT_EQ(closing_factor(2.0, 0.125), 0.75);
  EXPECT_EQ(closing_factor(2.0, 0.5), 0);
  EXPECT_EQ(closing_factor(2.0, 9.0), 0);
  EXPECT_EQ(closing_factor(0.0, 9.0), 1) << "without a rate";
}

TEST(Seam, HasNoGapOnceItIsClosedWhateverTheDirectionInWhichItOpened) {
  // The particles were at one place but for rounding; other constraints have drawn them apart across that gap.
  OneConstraint<Seam, float> one({{{0, 0, 0}, {1e-8, 0, 0}}}, {1, 1}, 0);
  one.max_start_step = static_cast<float>(kMaxStartStep);
  one.move(0, {0, 0.01, 0}), one.move(1, {0, 0, 0.02});
  one.project<Update::Compliant>(1, 0);
  EXPECT_LT(std::abs(one.C()), 1e-7f);
  EXPECT_NEAR(one.p(0).y, 0.005, 1e-7);
  EXPECT_NEAR(one.p(0).z, 0.01, 1e-7);
}

}  // namespace
}  // namespace malha
