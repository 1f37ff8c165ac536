// SPDX-License-Identifier: Apache-2.0
// One loose particle under gravity and wind, against the formulas of symplectic Euler and of physics.
#include <gtest/gtest.h>

#include "tests/small_scenes.h"

namespace malha {
namespace {

TEST(FreeFall, IsSymplecticEulerToTheLastDigits) {
  const Vec3 x0{1, 20, -3}, v0{2, 5, 0.5};
  const Scene scene = scene_of({particle(x0, v0)}, kEarth, 0.01);
  const Simulation simulation = after(scene, 1.5);
  const double h = 0.01, n = 150, t = n * h;
  const Vec3 v{v0[0], v0[1] - kG * t, v0[2]};
  const Vec3 x{x0[0] + v0[0] * t, x0[1] + v0[1] * t - kG * h * h * n * (n + 1) / 2, x0[2] + v0[2] * t};
  EXPECT_LT(length(simulation.velocities()[0] - v), 1e-12);  // 150 roundings of numbers around 10
  EXPECT_LT(length(simulation.positions()[0] - x), 1e-12);
  EXPECT_NEAR(simulation.time(), t, 1e-12);
}

TEST(FreeFall, ErrorAgainstTheParabolaHalvesWithTheTimeStep) {
  const auto error = [](double h) {
    return after(scene_of({particle({0, 0, 0})}, kEarth, h), 1).positions()[0][1] - -kG / 2;
  };
  const double coarse = error(0.02), middle = error(0.01), fine = error(0.005);
  EXPECT_NEAR(coarse, -kG * 0.02 / 2, 1e-12);  // symplectic Euler's error after 1 s is -g h / 2, with nothing beyond it
  EXPECT_NEAR(coarse / middle, 2, 1e-9);
  EXPECT_NEAR(middle / fine, 2, 1e-9);
}

TEST(FreeFall, SubstepsAreShorterSteps) {
  const BodySpec body = particle({0, 3, 0}, {1, 0, 0});
  const Simulation steps = after(scene_of({body}, kEarth, 0.01), 1);
  const Simulation substeps = after(scene_of({body}, kEarth, 0.04, 4), 1);
  EXPECT_LT(length(steps.positions()[0] - substeps.positions()[0]), 1e-12);
  EXPECT_LT(length(steps.velocities()[0] - substeps.velocities()[0]), 1e-12);
}

// In float, p - x over a short substep is rounded to few digits: if the velocity were computed from it, the particle
// would stop in the air. Gravity must act however high the particle is and however short the substep.
class FloatFall : public testing::TestWithParam<double> {};

TEST_P(FloatFall, KeepsGravityAtManySubsteps) {
  for (const int substeps : {10, 40, 160}) {
    const Scene scene = scene_of({particle({0, GetParam(), 0})}, kEarth, 1.0 / 60, substeps, Precision::Float);
    const Simulation simulation = after(scene, 1);
    // 9,600 additions of g h to a velocity of up to 10 m/s, each rounded by up to 5e-7 m/s; a systematic part remains.
    EXPECT_NEAR(simulation.velocities()[0][1], -kG, 2e-3) << substeps;
    const double h = 1.0 / 60 / substeps, exact = -kG / 2 * (1 + h);
    // Every substep rounds the position by up to half its spacing, 3e-5 m at 1 km; about half of it is systematic.
    EXPECT_NEAR(simulation.positions()[0][1] - GetParam(), exact, 1e-3 + 3e-6 * GetParam()) << substeps;
  }
}

INSTANTIATE_TEST_SUITE_P(Heights, FloatFall, testing::Values(3.0, 100.0, 1000.0));

Scene windy(double mass, const Vec3& wind, double drag, const Vec3& gravity, double h) {
  Scene scene = scene_of({particle({0, 0, 0}, {}, mass)}, gravity, h);
  scene.wind = Wind{wind, drag};
  return scene;
}

// Gravity is applied after drag, so that a hanging body still has its whole weight; a falling one ends g h faster than
// it should.
TEST(Drag, TerminalVelocityIsTheWindsPlusWeightOverDragToFirstOrder) {
  const double mass = 0.3, drag = 0.7;
  const Vec3 wind{2, 0.5, -1};
  for (const double h : {0.1, 0.01, 0.001}) {
    // 12 s are 28 relaxation times m / b: the transient is below 1e-8 even with the long step.
    const Simulation simulation = after(windy(mass, wind, drag, kEarth, h), 12);
    const Vec3 terminal{wind[0], wind[1] - mass * kG / drag - kG * h, wind[2]};
    EXPECT_LT(length(simulation.velocities()[0] - terminal), 1e-8) << h;
  }
}

TEST(Drag, DrawsExponentiallyTowardsTheWindToFirstOrder) {
  const double mass = 2, drag = 3, wind = 4, t = 0.8;
  const double exact = wind * (1 - std::exp(-drag / mass * t));
  const auto error = [&](double h) {
    return after(windy(mass, {wind, 0, 0}, drag, {}, h), t).velocities()[0][0] - exact;
  };
  const double coarse = error(0.02), fine = error(0.01);
  const double implicit_euler = wind * (1 - std::pow(1 + 0.02 * drag / mass, -40)) - exact;
  EXPECT_NEAR(coarse, implicit_euler, 1e-12);
  EXPECT_NEAR(coarse / fine, 2, 0.05);  // the second-order term is 1.5 % of the first at h b / m = 0.03
}

TEST(Drag, IsStableHoweverStrong) {
  const Simulation simulation = after(windy(1e-3, {1, 0, 0}, 1e6, {}, 0.1), 1);
  EXPECT_LT(length(simulation.velocities()[0] - Vec3{1, 0, 0}), 1e-8);  // m / (b h) = 1e-8 of it a step
}

}  // namespace
}  // namespace malha
