// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "kernels/constraints/constraint_registry.h"
#include "kernels/projection/rest.h"
#include "malha/mesh.h"

namespace malha {
namespace {

/// The sum over all constraints.
template <class Kind>
Residual residual(const std::vector<Vec3>& X, const std::vector<Vec3>& x, const std::vector<double>& w,
                  const std::vector<int>& particles, double parameter) {
  return parallel_reduce<Residual>(
      Serial{}, static_cast<int>(particles.size()) / Kind::particles,
      MeasureResidual<Kind, Vec3>{
          {X.data(), particles.data()}, x.data(), w.data(), particles.data(), {parameter}, nullptr});
}

TEST(MeasureResidual, AddsUpTheStrainsOfAChain) {
  // 20 particles a metre apart, then stretched: link c by (c + 1) / 1000 m.
  std::vector<Vec3> X, x;
  std::vector<double> w;
  std::vector<int> particles;
  double along = 0;
  for (int i = 0; i < 20; ++i) {
    X.push_back({double(i), 0, 0});
    w.push_back(i == 0 ? 0 : 1);
    if (i > 0) particles.insert(particles.end(), {i - 1, i}), along += 1 + i * 1e-3;
    x.push_back({along, 0, 0});
  }
  const Residual chain = residual<Distance>(X, x, w, particles, 1);
  EXPECT_EQ(chain.count, 19);
  EXPECT_EQ(chain.degenerate, 0);
  EXPECT_NEAR(chain.strain_max, 19e-3, 1e-12);
  EXPECT_NEAR(chain.C2, 1e-6 * 19 * 20 * 39 / 6, 1e-12);  // 1 + 4 + 9 + ... + 19^2
  EXPECT_NEAR(chain.strain2, chain.C2, 1e-15);
  // Compared with half of the rest lengths: C = (1 + e) - 1/2 and strain C / (1/2).
  const Residual halved = residual<Distance>(X, x, w, particles, 0.5);
  EXPECT_NEAR(halved.strain_max, 1 + 38e-3, 1e-12);
  EXPECT_NEAR(halved.strain2, 4 * halved.C2, 1e-12);
  EXPECT_NEAR(halved.C2, chain.C2 + 1e-3 * 190 + 19 * 0.25, 1e-12);
}

TEST(MeasureResidual, CountsWhatHasNoDirectionAndCouldMove) {
  const std::vector<Vec3> X{{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {6, 0, 0}};
  const std::vector<Vec3> x{{5, 5, 5}, {5, 5, 5}, {7, 7, 7}, {7, 7, 7}};
  const std::vector<int> particles{0, 1, 2, 3};
  const std::vector<double> some_pinned{0.5, 2, 0, 0};
  EXPECT_EQ(residual<Distance>(X, x, some_pinned, particles, 1).degenerate, 1) << "what is pinned would not move";
  EXPECT_EQ(residual<Distance>(X, X, some_pinned, particles, 1).degenerate, 0);
  // Coincident ends are too close by the whole length, and within any elongation limit.
  const Residual collapsed = residual<Distance>(X, x, {1, 1, 1, 1}, particles, 1);
  EXPECT_EQ(collapsed.C2, 2 * 4);
  EXPECT_EQ(collapsed.strain_max, 1);
  EXPECT_EQ(residual<DistanceLimit>(X, x, {1, 1, 1, 1}, particles, 0.1).C2, 0);
}

TEST(MeasureResidual, OfAFlatSheetsIsometricFoldIsMetAndNotDegenerate) {
  const std::vector<Vec3> X{{0, 0, 0}, {1, 0, 0}, {0.3, 0.7, 0}, {0.6, -0.9, 0}};
  const Residual flat = residual<IsometricBending>(X, X, {1, 1, 1, 1}, {0, 1, 2, 3}, 1);
  EXPECT_EQ(flat.degenerate, 0);
  EXPECT_LT(flat.C2, 1e-30);
}

TEST(MeasureResidual, OfAnInequalityThatHoldsIsNothing) {
  const std::vector<Vec3> X{{0, 0, 0}, {1, 0, 0}};
  const std::vector<double> w{1, 1};
  EXPECT_EQ(residual<DistanceLimit>(X, {{0, 0, 0}, {0.5, 0, 0}}, w, {0, 1}, 0.1).C2, 0);
  EXPECT_EQ(residual<DistanceLimit>(X, {{0, 0, 0}, {1.05, 0, 0}}, w, {0, 1}, 0.1).C2, 0);
  EXPECT_NEAR(residual<DistanceLimit>(X, {{0, 0, 0}, {1.2, 0, 0}}, w, {0, 1}, 0.1).C2, 0.01, 1e-12);
}

TEST(MeasureResidual, OfAHingeIsItsAngle) {
  // The hinge is flat at rest, then folded by a quarter turn.
  const std::vector<Vec3> X{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  const std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const double quarter = 3.14159265358979323846 / 2;
  const Residual folded = residual<Bending>(X, x, {1, 1, 1, 1}, {0, 1, 2, 3}, 1);
  EXPECT_NEAR(folded.C2, quarter * quarter, 1e-12);
  EXPECT_EQ(folded.degenerate, 0);
  EXPECT_EQ(
      residual<Bending>(X, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}}, {1, 1, 1, 1}, {0, 1, 2, 3}, 1).degenerate, 1)
      << "a triangle without area";
}

TEST(RestValue, IsTheKindsFromTheRestPositions) {
  const std::vector<Vec3> X{{1, 2, 3}, {9, 9, 9}, {3, 5, 9}};
  const int particles[] = {2, 0};
  const RestPositions<Vec3> at_rest{X.data(), particles};
  EXPECT_NEAR((rest_value<Distance>(at_rest, 0, 1)), 7, 1e-15);
  EXPECT_NEAR((rest_value<Distance>(at_rest, 0, 0.5)), 3.5, 1e-15);
  EXPECT_NEAR((rest_value<DistanceLimit>(at_rest, 0, 0.1)), 7.7, 1e-14);
}

TEST(RestValue, IsFromTheConstraintsOwnCornersIfItHasThem) {
  const std::vector<Vec3> X(3), own{{0, 0, 0}, {9, 0, 0}, {1, 2, 3}, {3, 5, 9}};
  const int particles[] = {2, 0, 0, 1};
  EXPECT_NEAR((rest_value<Distance>(RestPositions<Vec3>{X.data(), particles, own.data()}, 1, 1)), 7, 1e-15);
}

}  // namespace
}  // namespace malha
