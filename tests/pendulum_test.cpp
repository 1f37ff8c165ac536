// A mass on a rod (a chain of one stiff segment) against the formulas of the pendulum.
#include <gtest/gtest.h>

#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kPendulumStep = 0.01;  // s
const double kSmallPeriod = 2 * kPi * std::sqrt(1 / 9.81);

/// A rod of 1 m with 1 kg at its end, `angle` (rad) off the vertical, at rest.
Scene pendulum(double angle, int substeps, Precision precision = Precision::Double) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {std::sin(angle), -std::cos(angle), 0}, 1)}, kEarth, kPendulumStep,
                         substeps, precision);
  scene.bodies[0].constraints = {stiff("distance", {"edges"})};
  return scene;
}

/// From the first passage through the vertical to the third, the passages interpolated between steps.
double period(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  std::vector<double> passages;
  for (double before = simulation.positions()[1][0]; passages.size() < 3;) {
    simulation.step();
    const double x = simulation.positions()[1][0];
    if ((x < 0) != (before < 0)) passages.push_back(simulation.time() - kPendulumStep * x / (x - before));
    before = x;
  }
  return passages[2] - passages[0];
}

TEST(Pendulum, SmallAnglePeriodConvergesToTwoPiRootOfLengthOverGravity) {
  const double angle = 0.01;
  const auto error = [&](int substeps) {
    return period(pendulum(angle, substeps)) / kSmallPeriod - (1 + angle * angle / 16);
  };
  const double one = error(1), two = error(2), four = error(4);
  EXPECT_LT(std::abs(error(16)), 2e-6);  // (omega h)^2 / 24 of leapfrog is 2e-7; interpolation of passages adds as much
  EXPECT_NEAR(one / two, 4, 0.3);        // second order in h; the next order is (omega h)^2 = 1e-3 of it
  EXPECT_NEAR(two / four, 4, 0.3);
}

class LargeSwing : public testing::TestWithParam<double> {};

TEST_P(LargeSwing, PeriodConvergesToTheEllipticIntegral) {
  const double exact = 4 * std::sqrt(1 / 9.81) * std::comp_ellint_1(std::sin(GetParam() / 2));
  const auto error = [&](int substeps) { return period(pendulum(GetParam(), substeps)) / exact - 1; };
  const double coarse = error(16), fine = error(64);
  // Second order but for the start, of first order: the first substep falls by all of g h^2.
  EXPECT_LT(std::abs(fine), std::abs(coarse) / 4);
  EXPECT_LT(std::abs(fine), GetParam() > 2 ? 0.03 : 1e-3);  // near the top the period hangs on every bit of energy
}

INSTANTIATE_TEST_SUITE_P(Radians, LargeSwing, testing::Values(1.0, 2.5));

/// Of a projection along the direction where the substep began the energy swings by a part of the second order, and
/// does not drift: 9.5 J of which a swing from almost the top with one substep shows 0.02 too much.
TEST(Pendulum, KeepsItsEnergyTheBetterTheMoreSubsteps) {
  double off_before = INFINITY;
  for (const int substeps : {1, 4, 16}) {
    Simulation simulation(pendulum(2.9, substeps), {.threads = 1});
    const double start = simulation.measure().energy();
    double off = 0, most = 0;
    for (int step = 0; step < 500; ++step) {
      simulation.step();
      off = std::max(off, std::abs(simulation.measure().energy() - start));
      most = std::max(most, simulation.measure().energy() - start);
    }
    EXPECT_LT(most, 0.005 * start) << substeps;
    EXPECT_LT(off, 0.7 * off_before) << substeps;
    off_before = off;
  }
}

TEST(Pendulum, OfManySegmentsGainsNoEnergy) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {1, 0, 0}, 10, 0.1)}, kEarth, kPendulumStep, 20);
  scene.bodies[0].constraints = {stiff("distance", {"edges"})};
  Simulation simulation(scene, {.threads = 1});
  const double start = simulation.measure().energy();
  for (int step = 0; step < 300; ++step) {
    simulation.step();
    ASSERT_LE(simulation.measure().energy(), start + 1e-3) << step << ", of 0.5 J that it falls by";
  }
}

TEST(Pendulum, KeepsItsLength) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Simulation simulation(pendulum(2.5, 10, precision), {.threads = 1});
    // The projection of one segment is exact: what remains is the rounding of a position of 1 m, and of its projection.
    const double rounding = precision == Precision::Float ? 2e-7 : 4e-16;
    for (int step = 0; step < 200; ++step) {
      simulation.step();
      ASSERT_NEAR(length(simulation.positions()[1]), 1, rounding) << step;
    }
  }
}

}  // namespace
}  // namespace malha
