// SPDX-License-Identifier: Apache-2.0
// A mass on a rod (a chain of one stiff segment) against the formulas of the pendulum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

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

/// The root between 0 and 1 of the cubic through (-1, x0), (0, x1), (1, x2), (2, x3), by bisection.
double passage(double x0, double x1, double x2, double x3) {
  double low = 0, high = 1;
  for (int k = 0; k < 52; ++k) {
    const double s = (low + high) / 2;
    const double x = (x3 * (s + 1) - x0 * (s - 2)) * s * (s - 1) / 6 + (x1 * (s - 1) - x2 * s) * (s + 1) * (s - 2) / 2;
    ((x < 0) == (x1 < 0) ? low : high) = s;
  }
  return low;
}

/// The time from the first passage through the vertical to the third, with passages interpolated between steps.
double period(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  std::vector<double> passages, x(4, simulation.positions()[1][0]);
  while (passages.size() < 3) {
    simulation.step();
    x.erase(x.begin()), x.push_back(simulation.positions()[1][0]);
    if ((x[1] < 0) != (x[2] < 0))
      passages.push_back(simulation.time() - kPendulumStep * (2 - passage(x[0], x[1], x[2], x[3])));
  }
  return passages[2] - passages[0];
}

/// Energy in J at the time of the positions. Velocities are those half a substep earlier, and the power of the weight,
/// gravity times momentum, makes up the difference: without that the energies would oscillate, to first order.
double energy_now(const Simulation& simulation, const Scene& scene) {
  const Measures measures = simulation.measure();
  const double substep = scene.solver.dt / scene.solver.substeps;
  return measures.energy() - substep / 2 * kG * measures.momentum[1];
}

TEST(Pendulum, SmallAnglePeriodConvergesToTwoPiRootOfLengthOverGravity) {
  const double angle = 0.01;
  const auto error = [&](int substeps) {
    return period(pendulum(angle, substeps)) / kSmallPeriod - (1 + angle * angle / 16);
  };
  const double one = error(1), two = error(2), four = error(4);
  EXPECT_NEAR(error(16), -9.81 * 0.01 * 0.01 / 256 / 24, 1e-9);  // -(omega h)^2 / 24 of leapfrog is -1.6e-7
  EXPECT_NEAR(one / two, 4, 0.02);  // second order in h; the next order is (omega h)^2 = 1e-3 of it
  EXPECT_NEAR(two / four, 4, 0.02);
}

class LargeSwing : public testing::TestWithParam<double> {};

TEST_P(LargeSwing, PeriodConvergesToTheEllipticIntegral) {
  const double exact = 4 * std::sqrt(1 / 9.81) * std::comp_ellint_1(std::sin(GetParam() / 2));
  const auto error = [&](int substeps) { return period(pendulum(GetParam(), substeps)) / exact - 1; };
  const double two = error(2), eight = error(8), thirty_two = error(32);
  // Second order also where the rod turns by much in a substep; passages of the fastest are known to 1e-9 of a period.
  EXPECT_NEAR(two / eight, 16, 0.1);
  EXPECT_NEAR(eight / thirty_two, 16, 0.3);
  EXPECT_LT(std::abs(thirty_two), 2e-7);
}

INSTANTIATE_TEST_SUITE_P(Radians, LargeSwing, testing::Values(1.0, 2.5));

/// The smallest and the largest excess of the energy over that at the start in that many steps, J.
std::pair<double, double> swing_of_energy(Simulation& simulation, const Scene& scene, int steps, double start) {
  std::pair<double, double> swing{INFINITY, -INFINITY};
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    const double gained = energy_now(simulation, scene) - start;
    swing = {std::min(swing.first, gained), std::max(swing.second, gained)};
  }
  return swing;
}

/// Projection along the direction where the substep began neither gains nor loses energy: from almost the top, with 9.5
/// J, it oscillates by an amount that falls with the square of the substep, and is as large after 20 s as at first.
TEST(Pendulum, SwingsInItsEnergyBySecondOrderAndNeverDrifts) {
  double before = 0;
  for (const int substeps : {1, 4, 16}) {
    const Scene scene = pendulum(2.9, substeps);
    Simulation simulation(scene, {.threads = 1});
    const double start = simulation.measure().energy();
    const auto [least, most] = swing_of_energy(simulation, scene, 500, start);
    swing_of_energy(simulation, scene, 1000, start);
    const auto [least_at_last, most_at_last] = swing_of_energy(simulation, scene, 500, start);
    const double swing = most - least;
    // Steps sample the fastest positions by chance: within half a step of 0.01 s, of which a swing takes 300.
    EXPECT_NEAR(least_at_last, least, 0.003 * swing) << substeps;
    EXPECT_NEAR(most_at_last, most, 0.003 * swing) << substeps;
    EXPECT_LT(swing, 0.0021 * start / (substeps * substeps)) << substeps;
    EXPECT_NEAR(substeps == 1 ? 16 : before / swing, 16, 0.3) << substeps;
    before = swing;
  }
}

/// The energy that ten segments lose is what their sweeps do not resolve when they whip.
TEST(Pendulum, OfManySegmentsNeverGainsEnergy) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {1, 0, 0}, 10, 0.1)}, kEarth, kPendulumStep, 20);
  scene.bodies[0].constraints = {stiff("distance", {"edges"})};
  Simulation simulation(scene, {.threads = 1});
  const double start = simulation.measure().energy();
  for (int step = 0; step < 300; ++step) {
    simulation.step();
    ASSERT_LE(energy_now(simulation, scene), start) << step;
  }
}

TEST(Pendulum, KeepsItsLength) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Simulation simulation(pendulum(2.5, 10, precision), {.threads = 1});
    // The projection of one segment is exact: the error is the rounding of a position of 1 m, and of its projection.
    const double rounding = precision == Precision::Float ? 2e-7 : 4e-16;
    for (int step = 0; step < 200; ++step) {
      simulation.step();
      ASSERT_NEAR(length(simulation.positions()[1]), 1, rounding) << step;
    }
  }
}

}  // namespace
}  // namespace malha
