// SPDX-License-Identifier: Apache-2.0
// A mass on an XPBD spring: rest 1 m, start 1.5 m, 1 kg, compliance 0.001 m/N. With u = |x| - 1 m and omega^2 = 1 / (m
// alpha), XPBD's update of one constraint is implicit Euler, v' = v - h omega^2 u', u' = u + h v': the eigenvalues of
// that step are 1 / (1 -+ i omega h), so that the amplitude falls by 1 / sqrt(1 + omega^2 h^2) a step, exactly, and the
// phase advances by atan(omega h): a period of 2 pi h / atan(omega h), which tends to 2 pi sqrt(m alpha) as h^2.
#include <gtest/gtest.h>

#include <complex>

#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kAlpha = 0.001;
const double kOmega = std::sqrt(1 / kAlpha);

Scene oscillator(double h, int substeps = 1, int iterations = 1, Precision precision = Precision::Double) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {1.5, 0, 0}, 1)}, {}, h * substeps, substeps, precision);
  scene.solver.iterations = iterations;
  scene.bodies[0].constraints = {compliant("distance", kAlpha, {"edges"}, 1 / 1.5)};
  return scene;
}

double stretch(const Simulation& simulation) { return simulation.positions()[1][0] - 1; }

/// Four periods from the first passage through the rest length on, by interpolation.
double period(double h) {
  Simulation simulation(oscillator(h), {.threads = 1});
  std::vector<double> passages;
  for (double before = stretch(simulation); passages.size() < 9;) {
    simulation.step();
    const double u = stretch(simulation);
    if ((u < 0) != (before < 0)) passages.push_back(simulation.time() - h * u / (u - before));
    before = u;
  }
  return (passages[8] - passages[0]) / 4;
}

TEST(Oscillator, PeriodConvergesToTheAnalyticOneAsTheSquareOfTheTimeStep) {
  const double exact = 2 * kPi * std::sqrt(kAlpha);
  const auto error = [&](double h) { return period(h) / exact - 1; };
  const double coarse = error(2e-3), middle = error(1e-3), fine = error(5e-4);
  EXPECT_NEAR(fine, kOmega * kOmega * 25e-8 / 3, 1e-5);  // atan(s) = s - s^3 / 3; passages are interpolated
  EXPECT_NEAR(coarse / middle, 4, 0.2);
  EXPECT_NEAR(middle / fine, 4, 0.2);
}

TEST(Oscillator, AmplitudeFallsByImplicitEulersFactor) {
  const double h = 1e-3, t = 1;
  const Simulation simulation = after(oscillator(h), t);
  const double start = kOmega * kOmega * 0.25;  // u^2 omega^2 + v^2, of which each step keeps 1 / (1 + omega^2 h^2)
  const double v = simulation.velocities()[1][0], u = stretch(simulation);
  EXPECT_NEAR((kOmega * kOmega * u * u + v * v) / start, std::pow(1 + kOmega * kOmega * h * h, -1000), 1e-12);
}

TEST(Oscillator, IsImplicitEulerToTheLastDigits) {
  const std::complex<double> i(0, 1);
  for (const double h : {1e-4, 1e-3, 1e-2, 0.1}) {
    Simulation simulation(oscillator(h), {.threads = 1});
    // u + i v / omega turns by -omega h and shrinks: multiplied by 1 / (1 + i omega h) a step.
    std::complex<double> state = 0.5;
    for (int step = 0; step < 200; ++step) {
      simulation.step();
      state /= 1.0 + i * kOmega * h;
      ASSERT_NEAR(stretch(simulation), state.real(), 1e-11) << h << ", step " << step;
      ASSERT_NEAR(simulation.velocities()[1][0] / kOmega, state.imag(), 1e-11) << h << ", step " << step;
    }
  }
}

TEST(Oscillator, IterationsChangeNothingWhereOneConstraintIsSolvedAtOnce) {
  const Simulation one = after(oscillator(1e-3), 0.5), five = after(oscillator(1e-3, 1, 5), 0.5);
  EXPECT_NEAR(stretch(one), stretch(five), 1e-12);
}

TEST(Oscillator, SubstepsAreShorterSteps) {
  const Simulation steps = after(oscillator(1e-3), 0.5), substeps = after(oscillator(1e-3, 10), 0.5);
  EXPECT_NEAR(stretch(steps), stretch(substeps), 1e-12);
}

TEST(Oscillator, FloatFollowsDouble) {
  const Simulation exact = after(oscillator(1e-4), 0.5);
  const Simulation single = after(oscillator(1e-4, 1, 1, Precision::Float), 0.5);
  // 5,000 steps round a position of 1 m by 6e-8 m each, up or down alike; the velocity by 6e-8 / h.
  EXPECT_NEAR(stretch(single), stretch(exact), 1e-4);
}

TEST(Oscillator, EnergyOfTheSpringIsItsStretchSquaredOverTwiceTheCompliance) {
  const Simulation simulation = after(oscillator(1e-3), 0.123);
  const double u = stretch(simulation);
  EXPECT_NEAR(simulation.measure().elastic, u * u / (2 * kAlpha), 1e-9);
  EXPECT_GT(simulation.measure().elastic, 1);
}

TEST(Oscillator, OfTwoFreeMassesSwingsWithTheReducedMass) {
  Scene scene = oscillator(1e-3);
  scene.bodies[0].pins.clear();  // 1 kg at either end: the reduced mass is 0.5 kg
  const double omega = std::sqrt(2 / kAlpha);
  const Simulation simulation = after(scene, 0.2);
  const std::complex<double> state = 0.5 * std::pow(1.0 + std::complex<double>(0, omega * 1e-3), -200);
  const std::vector<Vec3> x = simulation.positions();
  EXPECT_NEAR(length(x[1] - x[0]) - 1, state.real(), 1e-11);
  EXPECT_NEAR(x[0][0] + x[1][0], 1.5, 1e-12);  // the centre of mass stays
}

}  // namespace
}  // namespace malha
