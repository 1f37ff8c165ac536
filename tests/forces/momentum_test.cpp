// SPDX-License-Identifier: Apache-2.0
// A free body keeps its momentum, whatever its constraints and damping do inside it.
#include <gtest/gtest.h>

#include "tests/mesh/mesh_files.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// A body of 642 particles.
BodySpec ellipsoid(std::vector<ConstraintSpec> constraints) { return tumbling_ellipsoid(3, std::move(constraints)); }

/// Momenta of all particles, pinned ones included: the bodies here have no pins.
struct Momenta {
  Vec3 linear, angular;
  double kinetic;
};
Momenta momenta(const Simulation& simulation) {
  const Measures m = simulation.measure();
  return {m.momentum, m.angular_momentum, m.kinetic};
}

class FreeBody : public testing::TestWithParam<Precision> {
 protected:
  /// The tolerance of the momentum (kg m/s) of `particles` with the total `mass` after some substeps: a projection
  /// rounds a position of up to 2 m, which a substep turns into a velocity; all roundings add up like a random walk.
  static double rounding(double mass, double particles, double substeps, double h) {
    const double position = GetParam() == Precision::Float ? 1.2e-7 : 2.2e-16;
    const double projections = 25;  // of a particle in a substep: edges, hinges, pressure
    return 3 * mass * position / h * std::sqrt(projections * substeps / particles);
  }
};

TEST_P(FreeBody, KeepsItsLinearMomentumUnderEveryConstraint) {
  const std::vector<std::vector<ConstraintSpec>> every{
      {stiff("distance", {"edges"}), stiff("bending", {}, 0.3), stiff("pressure", {}, 1, 1.3)},
      {compliant("distance", 1e-4, {"edges"}), compliant("bending", 0.1), compliant("pressure", 3e-5, {}, 1.3)},
      {stiff("distance_limit", {"edges"}, 1, 0.05), stiff("distance", {"edges"}, 0.3, 1.2)}};
  for (std::size_t which = 0; which < every.size(); ++which) {
    BodySpec body = ellipsoid(every[which]);
    body.damping = 0.1;
    const Scene scene = scene_of({body}, {}, 1.0 / 60, 10, GetParam());
    Simulation simulation(scene, {.threads = 1});
    const Momenta before = momenta(simulation);
    run_for(simulation, scene, 1);
    const Momenta now = momenta(simulation);
    EXPECT_LT(length(now.linear - before.linear), rounding(2, 642, 600, 1.0 / 600)) << which;
    EXPECT_GT(std::abs(now.kinetic - before.kinetic), 1e-3) << which;  // it did deform
  }
}

// Each projection moves its particles along the gradients where the substep began, which exert no torque about those
// positions, converged or not.
TEST_P(FreeBody, KeepsItsAngularMomentumUnderEveryConstraint) {
  const std::vector<std::vector<ConstraintSpec>> every{
      {stiff("distance", {"edges"}), stiff("bending", {}, 0.3), stiff("pressure")},
      {compliant("distance", 1e-4, {"edges"}), compliant("bending", 0.1), compliant("pressure", 3e-5)},
      {stiff("distance_limit", {"edges"}, 1, 0.05), stiff("distance", {"edges"}, 0.3)}};
  for (std::size_t which = 0; which < every.size(); ++which)
    for (const int substeps : {5, 20}) {
      const Scene scene = scene_of({ellipsoid(every[which])}, {}, 1.0 / 60, substeps, GetParam());
      Simulation simulation(scene, {.threads = 1});
      const Vec3 before = momenta(simulation).angular;
      run_for(simulation, scene, 1);
      // 1,200 substeps of 642 particles with velocities of 4 m/s, rounded.
      const double rounding = GetParam() == Precision::Float ? 1e-5 : 1e-13;
      EXPECT_LT(length(momenta(simulation).angular - before), rounding * length(before)) << which << ", " << substeps;
    }
}

TEST(BreathingBody, DoesNotTurn) {
  BodySpec body = ellipsoid(
      {compliant("distance", 1e-3, {"edges"}), compliant("bending", 0.1), compliant("pressure", 0.03, {}, 1.3)});
  body.spin = body.velocity = {};
  for (const int substeps : {5, 20}) {
    Simulation simulation(scene_of({body}, {}, 1.0 / 60, substeps), {.threads = 1});
    double angular = 0, kinetic = 0;
    for (int step = 0; step < 60; ++step) {
      simulation.step();
      const Momenta now = momenta(simulation);
      angular = std::max(angular, length(now.angular)), kinetic = std::max(kinetic, now.kinetic);
    }
    const double scale = 0.5 * std::sqrt(2 * *body.mass * kinetic);  // of a body of half a metre at those speeds
    EXPECT_GT(scale, 0.1);
    EXPECT_LT(angular, 1e-13 * scale) << substeps;
  }
}

INSTANTIATE_TEST_SUITE_P(, FreeBody, testing::Values(Precision::Float, Precision::Double), [](const auto& tested) {
  return std::string(tested.param == Precision::Float ? "Float" : "Double");
});

// Two masses on a rod: the transverse displacement that a substep predicts, omega h of its length, is the one that it
// makes, so that it turns by asin(omega h) each time, and keeps its angular momentum to the last digits.
TEST(SpinningRod, KeepsItsAngularMomentumAndTurnsAsProjectionSays) {
  const double h = 0.01, omega = 5;
  BodySpec rod;
  rod.name = "rod";
  rod.shape = ChainShape{{-0.5, 0, 0}, {0.5, 0, 0}, 1};
  rod.mass = 2;
  rod.spin = {0, 0, omega};
  rod.constraints = {stiff("distance", {"edges"})};
  Simulation simulation(scene_of({rod}, {}, h), {.threads = 1});
  for (int step = 1; step <= 6000; ++step) {
    simulation.step();
    ASSERT_NEAR(momenta(simulation).angular[2], 2 * 0.25 * omega, 1e-12) << step;
    const double angle = std::asin(omega * h) * step;
    ASSERT_NEAR(simulation.positions()[1][0], 0.5 * std::cos(angle), 1e-10) << step;
  }
}

TEST(Damping, LeavesTheMomentaOfATumblingBodyAlone) {
  for (const double damping : {0.1, 1.0}) {
    BodySpec body = ellipsoid({});  // without constraints every particle flies on: only damping acts
    body.damping = damping;
    const Scene scene = scene_of({body}, {}, 1.0 / 60, 10);
    Simulation simulation(scene, {.threads = 1});
    const Momenta before = momenta(simulation);
    run_for(simulation, scene, 0.5);
    const Momenta now = momenta(simulation);
    EXPECT_LT(length(now.linear - before.linear), 1e-12);  // 300 substeps of sums over 642 particles
    EXPECT_LT(length(now.angular - before.angular), 1e-12);
    EXPECT_LT(now.kinetic, before.kinetic - 0.03);  // the body flies apart, and that is damped
  }
}

TEST(Damping, LeavesRigidMotionAlone) {
  BodySpec body = ellipsoid({});
  body.damping = 1;
  const Scene damped = scene_of({body}, {}, 0.01);
  body.damping = 0;
  const Scene free = scene_of({body}, {}, 0.01);
  const auto v = after(damped, 0.01).velocities(), expected = after(free, 0.01).velocities();
  for (std::size_t i = 0; i < v.size(); ++i) ASSERT_LT(length(v[i] - expected[i]), 1e-13) << i;
}

TEST(Damping, OfAStraightChainHasNoInertiaAboutItselfAndStaysFinite) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    BodySpec chain;
    chain.name = "chain";
    chain.shape = ChainShape{{0, 0, 0}, {1, 2, 3}, 10};
    chain.mass = 1;
    chain.spin = {3, 0, -1};
    chain.damping = 1;
    const Scene scene = scene_of({chain}, {}, 1.0 / 60, 10, precision);
    Simulation simulation(scene, {.threads = 1});
    const Momenta before = momenta(simulation);
    run_for(simulation, scene, 0.5);
    const Momenta now = momenta(simulation);
    const double rounding = precision == Precision::Float ? 1e-4 : 1e-12;  // 300 substeps at 1e-7 or 1e-16
    EXPECT_LT(length(now.angular - before.angular), rounding);
    EXPECT_LT(length(now.linear - before.linear), rounding);
  }
}

TEST(Damping, ActsOnEveryBodyByItself) {
  BodySpec left = ellipsoid({}), right = left;
  left.damping = right.damping = 1;
  right.name = "right";
  right.transform.translate = {-5, 0, 0};
  right.velocity = {-2, 0, 0.3};
  right.spin = {0, -4, 1};
  const Scene together = scene_of({left, right}, {}, 0.01);
  const auto v = after(together, 0.2).velocities();
  const auto v_left = after(scene_of({left}, {}, 0.01), 0.2).velocities();
  const auto v_right = after(scene_of({right}, {}, 0.01), 0.2).velocities();
  for (std::size_t i = 0; i < v_left.size(); ++i) {
    ASSERT_LT(length(v[i] - v_left[i]), 1e-12) << i;
    ASSERT_LT(length(v[v_left.size() + i] - v_right[i]), 1e-12) << i;
  }
}

using DampingOfAMesh = MeshFiles;

TEST_F(DampingOfAMesh, ActsOnEveryPartByItself) {
  // Two triangles: each turns about its own centre, and the centres fly straight on at what the spin of the body gave
  // them; damped as one, they would keep circling each other.
  const std::string path =
      file("parts.obj", "v -1 0 0\nv -1 1 0\nv -2 0 0.5\nv 1 0 0\nv 1 1 0.2\nv 2 0 0\nf 1 2 3\nf 4 5 6\n");
  BodySpec body;
  body.name = "parts";
  body.shape = MeshFile{path};
  body.mass = 1;
  body.spin = {0, 1, 2};
  body.damping = 1;
  const Scene scene = scene_of({body}, {}, 0.01);
  Simulation simulation(scene, {.threads = 1});
  const auto centre_velocity = [&](std::size_t first) {
    const auto v = simulation.velocities();
    Vec3 sum{};
    for (std::size_t i = first; i < first + 3; ++i)
      for (int k = 0; k < 3; ++k) sum[k] += v[i][k] / 3;  // the corners of a triangle have equal masses
    return sum;
  };
  const Vec3 left = centre_velocity(0), right = centre_velocity(3);
  ASSERT_GT(length(left - right), 1);
  run_for(simulation, scene, 0.5);
  EXPECT_LT(length(centre_velocity(0) - left), 1e-13);
  EXPECT_LT(length(centre_velocity(3) - right), 1e-13);
}

/// Bodies of three kinds and sizes with constraints of five kinds, up to a kilometre away, for up to 8 s.
Scene random_flight(Random& random) {
  BodySpec body;
  body.name = "body", body.mass = random(0.2, 3);
  if (random.below(2) == 0)
    body.shape = GridShape{{random(0.3, 1), random(0.3, 1)}, {3 + random.below(6), 3 + random.below(6)}};
  else
    body.shape = SphereShape{random(0.1, 0.6), 1};
  body.transform.scale = {random(0.4, 2), random(0.4, 2), random(0.4, 2)};
  body.constraints = {stiff("distance", {"edges"})};
  if (const int kind = random.below(4); kind == 1)
    body.constraints = {compliant("distance", std::pow(10, random(-7, -3)), {"edges"})};
  else if (kind == 2)
    body.constraints.push_back(stiff("bending", {}, random(0.1, 1)));
  else if (kind == 3)
    body.constraints.push_back(compliant("bending", std::pow(10, random(-2, 1))));
  const double place = std::pow(10, random(-1, 3));
  body.transform.translate = {place, random(-1, 1) * place, random(-1, 1) * place};
  body.velocity = {random(-2, 2), random(-2, 2), random(-2, 2)};
  body.spin = {random(-4, 4), random(-4, 4), random(-4, 4)};
  Scene scene = scene_of({body}, {}, 1.0 / 60, 1 << random.below(6), Precision::Float);
  scene.duration = random(0.5, 8);
  return scene;
}

// The tolerance is relative to the fastest particle's speed: velocities are rounded by 6e-8 of themselves in each of up
// to 15,360 substeps, a random walk, and so are the velocities that projections add.
TEST(RandomFlights, KeepTheirLinearMomentumInFloatUpToAKilometreFromTheOrigin) {
  Random random(5);
  for (int n = 0; n < 100; ++n) {
    const Scene scene = random_flight(random);
    Simulation simulation(scene, {.threads = 1});
    const Measures before = simulation.measure();
    run_for(simulation, scene, scene.duration);
    const double changed = length(simulation.measure().momentum - before.momentum) / *scene.bodies[0].mass;
    EXPECT_LT(changed, 1e-4 * before.speed_max) << n;
  }
}

}  // namespace
}  // namespace malha
