// SPDX-License-Identifier: Apache-2.0
// Other features of a scene besides springs under Desbrun's method: distance limits, contact, pressure, wind and
// damping.
#include <gtest/gtest.h>

#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

/// A soft sheet hung by two corners, whose edges may stretch by 10 %.
Scene limited(int iterations, std::optional<double> tolerance = {}) {
  BodySpec sheet = sprung_sheet(10, {ListPin{{0, 10}}});
  sheet.constraints.push_back(stiff("distance_limit", {"edges"}, 1, 0.1));
  Scene scene = desbrun_scene({sheet}, 3);
  scene.solver.iterations = iterations;
  scene.solver.desbrun.tolerance = tolerance;
  return scene;
}

/// The largest over-elongation after `steps`, relative to limits of 1.1 times 5 cm.
double excess(const Scene& scene, int steps) {
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < steps; ++step) simulation.step();
  const std::vector<Vec3> x = simulation.positions();
  double most = 0;
  for (int i = 0; i < static_cast<int>(x.size()); ++i)
    for (const int next : {i % 11 < 10 ? i + 1 : -1, i + 11 < static_cast<int>(x.size()) ? i + 11 : -1})
      if (next >= 0) most = std::max(most, length(x[i] - x[next]) / (1.1 * 0.05) - 1);
  return most;
}

TEST(DistanceLimits, HoldWhatSpringsAloneWouldNot) {
  Scene unlimited = limited(1);
  unlimited.bodies[0].constraints.pop_back();
  EXPECT_GT(excess(unlimited, 60), 0.5);
  EXPECT_LT(excess(limited(100), 60), 0.1);
}

TEST(DistanceLimits, AreMetToTheToleranceAndThenLeftAlone) {
  for (const double tolerance : {0.2, 0.05, 0.01}) {
    const double found = excess(limited(10000, tolerance), 60);
    EXPECT_LE(found, tolerance);
    EXPECT_GT(found, tolerance / 10) << "more iterations than it takes were left out";
  }
}

std::uint64_t hash(const Scene& scene) { return after(scene, 0.5).state_hash(); }

// Where no limit is exceeded, the iterations that are skipped would have changed nothing.
TEST(DistanceLimits, WithoutToleranceAreTheSameBitsAsWithOneOfZero) {
  EXPECT_EQ(hash(limited(7, 0.0)), hash(limited(7)));
  EXPECT_NE(hash(limited(6, 0.0)), hash(limited(7))) << "they are not met by then";
}

TEST(DistanceLimits, ThatAreMetAtOnceCostOneIteration) {
  EXPECT_EQ(hash(limited(50, 1e9)), hash(limited(2, 1e9)));
  EXPECT_NE(hash(limited(50, 1e9)), hash(limited(2)));
}

TEST(DistanceLimits, StopAtTheSameIterationOnAnyNumberOfThreads) {
  Scene scene = limited(200, 0.02);
  scene.solver.precision = Precision::Float;
  const std::uint64_t one = after(scene, 0.5, {.threads = 1}).state_hash();
  EXPECT_EQ(after(scene, 0.5, {.threads = 3}).state_hash(), one);
  EXPECT_EQ(after(scene, 0.5, {.backend = Backend::Serial}).state_hash(), one);
}

EnvironmentSpec rough_ground(double friction = 0.5) {
  EnvironmentSpec ground;
  ground.name = "ground";
  ground.shape = GridShape{{6, 6}, {1, 1}};
  ground.transform.translate = {-3, 0, -3};
  ground.sides = Sides::OneSided;
  ground.thickness = 0.01, ground.friction = friction;
  return ground;
}

BodySpec ball(std::vector<ConstraintSpec> more = {}) {
  BodySpec ball;
  ball.name = "ball";
  ball.shape = SphereShape{0.5, 2};
  ball.transform.translate = {0, 0.7, 0};
  ball.mass = 1;
  ball.damping = 0.02;
  ball.constraints = {stiff("distance", {"edges"}), stiff("bending", {}, 0.03)};
  for (const ConstraintSpec& spec : more) ball.constraints.push_back(spec);
  return ball;
}

TEST(AFilteredBody, FallsOntoTheGroundAndStaysThere) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene scene = desbrun_scene({ball()}, 2e4, precision);
    // Contact pushes single particles, and the filter spreads the impulse over the body in the next step: with few long
    // steps a ball is flattened before it stops.
    scene.solver.substeps = 16;
    scene.environment = {rough_ground()};
    const Simulation simulation = after(scene, 4);
    double lowest = 1e9, highest = -1e9;
    for (const Vec3& x : simulation.positions()) lowest = std::min(lowest, x[1]), highest = std::max(highest, x[1]);
    // They are kept 1 cm away; particles rest on the surface to a rounding and the displacement of gravity in a step.
    EXPECT_NEAR(lowest, 0.01, 0.003);
    EXPECT_GT(highest, 0.8) << "and keeps its shape";
    EXPECT_GT(simulation.measure().contacts, 0);
    EXPECT_LT(simulation.measure().speed_max, 0.2);
  }
}

TEST(AFilteredBody, KeepsItsVolumeByPressure) {
  for (const double pressure : {0.8, 1.0, 1.5}) {
    Scene scene = desbrun_scene({ball({stiff("pressure", {}, 1, pressure)})}, 100, Precision::Float);
    scene.environment = {rough_ground()};
    const Simulation simulation = after(scene, 2);
    ASSERT_EQ(simulation.measure().volume_ratios.size(), 1u);
    EXPECT_NEAR(simulation.measure().volume_ratios[0], pressure, 0.02) << "by 10 iterations a step, against its weight";
  }
}

// The tolerance applies to distance limits: a scene without them does all its iterations.
TEST(AFilteredBody, WithoutDistanceLimitsIsGivenAllIterationsWhateverTheTolerance) {
  Scene scene = desbrun_scene({ball({stiff("pressure", {}, 0.5, 1.3)})}, 100, Precision::Float);
  scene.environment = {rough_ground()};
  const std::uint64_t all = hash(scene);
  scene.solver.desbrun.tolerance = 0.01;
  EXPECT_EQ(hash(scene), all);
  scene.solver.iterations = 1;
  EXPECT_NE(hash(scene), all);
}

TEST(AFilteredBody, SlidesOnSmoothGroundAndRestsOnRough) {
  const auto travelled = [](double friction) {
    BodySpec sheet = sprung_sheet(6);
    sheet.transform.translate = {0, 0.0101, 0};
    sheet.velocity = {1, 0, 0};
    Scene scene = desbrun_scene({sheet}, 1000);
    scene.environment = {rough_ground(friction)};
    Simulation simulation(scene, {.threads = 1});
    const double before = simulation.positions()[0][0];
    run_for(simulation, scene, 0.5);
    return simulation.positions()[0][0] - before;
  };
  EXPECT_NEAR(travelled(0), 0.5, 1e-6);
  EXPECT_NEAR(travelled(0.5), 1 / (2 * 0.5 * 9.81), 0.02) << "v^2 / (2 mu g), to a step's way";
}

TEST(AFilteredBody, IsDampedTowardsRigidMotionAndCarriedByTheWind) {
  BodySpec sheet = sprung_sheet(6);
  sheet.spin = {0, 1, 0}, sheet.damping = 0.5;
  sheet.constraints[0].parameter = 0.9;  // the sheet starts with an oscillation
  Scene scene = desbrun_scene({sheet}, 50);
  scene.gravity = {0, 0, 0};
  const Measures start = Simulation(scene, {.threads = 1}).measure(), damped = after(scene, 1).measure();
  EXPECT_LT(length(damped.angular_momentum - start.angular_momentum), 1e-12) << "turns on";
  scene.wind = Wind{{2, 0, 0}, 0.01};
  const std::vector<Vec3> v = after(scene, 1).velocities();
  for (const Vec3& u : v) EXPECT_NEAR(u[0], 2, 0.05);  // drag / m of 27 1/s
}

}  // namespace
}  // namespace malha
