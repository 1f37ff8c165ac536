// A free body keeps its momentum, whatever its constraints and damping do inside it.
#include <gtest/gtest.h>

#include "tests/mesh_files.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// Of 642 particles.
BodySpec ellipsoid(std::vector<ConstraintSpec> constraints) { return tumbling_ellipsoid(3, std::move(constraints)); }

/// Of all particles, pinned ones included: for bodies without pins, as here.
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
  /// What rounding may do to the momentum (kg m/s) of `particles` of together `mass` after some substeps: a projection
  /// rounds a position of up to 2 m, which a substep turns into a velocity; all of them add up like a random walk.
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

// Projections keep the angular momentum about the predicted positions, so that a step loses part of it where the body
// turns: PBD is a method of first order. The loss must fall with the length of the substeps.
TEST_P(FreeBody, KeepsItsAngularMomentumToFirstOrder) {
  const std::vector<std::vector<ConstraintSpec>> every{
      {stiff("distance", {"edges"}), stiff("bending", {}, 0.3), stiff("pressure")},
      {compliant("distance", 1e-4, {"edges"}), compliant("bending", 0.1), compliant("pressure", 3e-5)}};
  for (std::size_t which = 0; which < every.size(); ++which) {
    const auto loss = [&](int substeps) {
      const Scene scene = scene_of({ellipsoid(every[which])}, {}, 1.0 / 60, substeps, GetParam());
      Simulation simulation(scene, {.threads = 1});
      const Vec3 before = momenta(simulation).angular;
      run_for(simulation, scene, 1);
      return length(momenta(simulation).angular - before) / length(before);
    };
    const double coarse = loss(5), fine = loss(20);
    EXPECT_LT(coarse, 14.0 / 300) << which;  // omega^2 h t, as of a rod (below), omega^2 = 14 1/s^2
    EXPECT_LT(fine, coarse / 3) << which;
  }
}

TEST(BreathingBody, TurnsOnlyByAnErrorOfFirstOrder) {
  BodySpec body = ellipsoid(
      {compliant("distance", 1e-3, {"edges"}), compliant("bending", 0.1), compliant("pressure", 0.03, {}, 1.3)});
  body.spin = body.velocity = {};
  struct Most {
    double angular = 0, kinetic = 0;
  };
  const auto most = [&](int substeps) {
    Simulation simulation(scene_of({body}, {}, 1.0 / 60, substeps), {.threads = 1});
    Most found;
    for (int step = 0; step < 60; ++step) {
      simulation.step();
      const Momenta now = momenta(simulation);
      found = {std::max(found.angular, length(now.angular)), std::max(found.kinetic, now.kinetic)};
    }
    return found;
  };
  const Most coarse = most(5), fine = most(20);
  const double scale = 0.5 * std::sqrt(2 * *body.mass * fine.kinetic);  // of a body of half a metre at those speeds
  EXPECT_GT(scale, 0.1);
  EXPECT_LT(coarse.angular, 0.02 * scale);
  EXPECT_LT(fine.angular, coarse.angular / 4);
}

INSTANTIATE_TEST_SUITE_P(, FreeBody, testing::Values(Precision::Float, Precision::Double), [](const auto& tested) {
  return std::string(tested.param == Precision::Float ? "Float" : "Double");
});

// Two masses on a rod: prediction goes along the last chord, projection back along the rod, so that after an angle phi
// a step turns by atan2(sin phi, 2 - cos phi), after the first one of atan(omega h). Velocity: chord / h.
TEST(SpinningRod, LosesAngularMomentumAsProjectionSays) {
  const double h = 0.01, omega = 5;
  BodySpec rod;
  rod.name = "rod";
  rod.shape = ChainShape{{-0.5, 0, 0}, {0.5, 0, 0}, 1};
  rod.mass = 2;
  rod.spin = {0, 0, omega};
  rod.constraints = {stiff("distance", {"edges"})};
  Simulation simulation(scene_of({rod}, {}, h), {.threads = 1});
  double phi = std::atan(omega * h);
  for (int step = 0; step < 200; ++step) {
    simulation.step();
    ASSERT_NEAR(momenta(simulation).angular[2], 2 * 0.25 * std::sin(phi) / h, 1e-11) << step;
    phi = std::atan2(std::sin(phi), 2 - std::cos(phi));
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

}  // namespace
}  // namespace malha
