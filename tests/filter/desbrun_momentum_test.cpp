// SPDX-License-Identifier: Apache-2.0
// Momenta of a free body under Desbrun's filter: internal forces change neither, and its centre falls freely.
#include <gtest/gtest.h>

#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

using Parameters = std::tuple<Precision, FilterKind>;

std::string name_of(const testing::TestParamInfo<Parameters>& tested) {
  return std::string(std::get<0>(tested.param) == Precision::Float ? "Float" : "Double") +
         (std::get<1>(tested.param) == FilterKind::Dense ? "Dense" : "Sparse");
}

/// A body of 162 particles whose springs recover from a strain.
BodySpec ellipsoid() {
  return tumbling_ellipsoid(2, {stiff("distance", {"edges"}, 1, 0.9), stiff("bending", {}, 0.3)});
}

class FilteredBody : public testing::TestWithParam<Parameters> {
 protected:
  static Scene scene(double stiffness = 1e4) {
    Scene scene = desbrun_scene({ellipsoid()}, stiffness, std::get<0>(GetParam()));
    scene.solver.desbrun.filter = std::get<1>(GetParam());
    scene.gravity = {0, 0, 0};
    return scene;
  }
  static double rounding() { return std::get<0>(GetParam()) == Precision::Float ? 6e-8 : 1.1e-16; }
};

TEST_P(FilteredBody, KeepsItsLinearMomentumWhateverItsTorque) {
  for (const double stiffness : {1e2, 1e4, 1e6})
    for (const Corrector corrector : {Corrector::Inertia, Corrector::Off})
      for (const int refinements : {0, 3}) {
        Scene tested = scene(stiffness);
        tested.solver.desbrun.corrector = corrector, tested.solver.desbrun.refinement_iterations = refinements;
        Simulation simulation(tested, {.threads = 1});
        const Measures before = simulation.measure();
        run_for(simulation, tested, 0.5);
        const Measures now = simulation.measure();
        // 30 steps round velocities of up to 30 m/s, 2 kg together.
        EXPECT_LT(length(now.momentum - before.momentum), 2000 * rounding())
            << stiffness << ", refined " << refinements;
        EXPECT_GT(std::abs(now.kinetic - before.kinetic), 1e-3) << "it did deform";
      }
}

// L' = sum (x + dt v') x m v' = L + dt sum x x m a: without torque about the old positions the angular momentum is the
// same, although the step is of first order.
TEST_P(FilteredBody, KeepsItsAngularMomentumWithTheInertiaCorrector) {
  for (const double stiffness : {1e2, 1e4, 1e6}) {
    const Scene tested = scene(stiffness);
    Simulation simulation(tested, {.threads = 1});
    const Measures before = simulation.measure();
    for (int step = 0; step < 30; ++step) {
      simulation.step();
      // The same rounding, at 1 m from the origin.
      ASSERT_LT(length(simulation.measure().angular_momentum - before.angular_momentum), 2000 * rounding())
          << stiffness << ", step " << step;
    }
    EXPECT_GT(length(before.angular_momentum), 1);
  }
}

INSTANTIATE_TEST_SUITE_P(, FilteredBody,
                         testing::Combine(testing::Values(Precision::Float, Precision::Double),
                                          testing::Values(FilterKind::Dense, FilterKind::Sparse)),
                         name_of);

// Projections after the filter move particles at once, and so carry their velocities to other positions: without the
// corrector's share a balloon at 20 rad/s had seven times its angular momentum, and 50 times its energy, after 2 s.
TEST(ProjectionsAfterTheFilter, LeaveASpinningBodyItsAngularMomentum) {
  std::vector<BodySpec> bodies;
  for (const double compliance : {0.0, 1e-6})
    bodies.push_back(tumbling_ellipsoid(2, {stiff("distance", {"edges"}), compliant("pressure", compliance)}));
  for (BodySpec& body : bodies)
    for (const int substeps : {10, 40}) {
      body.spin = {1, 20, 0}, body.velocity = {0, 0, 0};
      Scene scene = desbrun_scene({body}, 1e4, Precision::Double);
      scene.gravity = {0, 0, 0}, scene.solver.substeps = substeps;
      Simulation simulation(scene, {.threads = 1});
      const Measures before = simulation.measure();
      for (int step = 0; step < 40; ++step) simulation.step();
      const Measures now = simulation.measure();
      EXPECT_LT(length(now.angular_momentum - before.angular_momentum), 1e-10 * length(before.angular_momentum))
          << body.constraints.back().type << ", " << substeps << " substeps";
      EXPECT_LT(now.kinetic, 1.1 * before.kinetic) << "it changes its shape, and with that its moment of inertia";
    }
}

/// The largest relative change of the angular momentum in a step.
double change_in_a_step(Corrector corrector, double stiffness) {
  Scene scene = desbrun_scene({ellipsoid()}, stiffness);
  scene.gravity = {0, 0, 0};
  scene.solver.desbrun.corrector = corrector;
  Simulation simulation(scene, {.threads = 1});
  const Vec3 before = simulation.measure().angular_momentum;
  simulation.step();
  return length(simulation.measure().angular_momentum - before) / length(before);
}

TEST(Corrector, OfInertiaTakesTheTorqueAwayThatTheFilterLeavesAndThePublishedOneAddsToIt) {
  for (const double stiffness : {1e3, 1e5}) {
    const double inertia = change_in_a_step(Corrector::Inertia, stiffness);
    const double off = change_in_a_step(Corrector::Off, stiffness);
    const double paper = change_in_a_step(Corrector::Paper, stiffness);
    EXPECT_LT(inertia, 1e-13) << stiffness;
    EXPECT_GT(off, 1e-4) << stiffness;
    EXPECT_GT(paper, 2 * off) << stiffness << ": it has not the dimension of a correction";
  }
}

/// The published formula lacks the inverse inertia: each particle has I^-1 T instead of T / m, so it
/// over-corrects by I / m, which grows with the number of particles.
TEST(Corrector, AsPublishedOverCorrectsTheMoreTheFinerTheMesh) {
  const auto change = [](int subdivisions) {
    BodySpec body = ellipsoid();
    body.shape = SphereShape{0.5, subdivisions};
    Scene scene = desbrun_scene({body}, 1e4);
    scene.gravity = {0, 0, 0};
    const auto torque = [&](Corrector corrector) {
      scene.solver.desbrun.corrector = corrector;
      Simulation simulation(scene, {.threads = 1});
      const Vec3 before = simulation.measure().angular_momentum;
      simulation.step();
      return simulation.measure().angular_momentum - before;
    };
    return length(torque(Corrector::Paper)) / length(torque(Corrector::Off));
  };
  EXPECT_GT(change(3), 2 * change(1));
}

/// The corrector acts on two bodies, and on the two parts of one, separately.
TEST(Corrector, ActsOnEveryPieceByItself) {
  BodySpec left = ellipsoid(), right = ellipsoid();
  right.name = "right";
  right.transform.translate = {-3, 0, 1};
  right.spin = {0, -5, 1};
  const auto positions = [](std::vector<BodySpec> bodies) {
    Scene scene = desbrun_scene(std::move(bodies), 1e4);
    scene.gravity = {0, 0, 0};
    return after(scene, 0.2).positions();
  };
  const std::vector<Vec3> both = positions({left, right}), one = positions({left}), other = positions({right});
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_LT(length(both[i] - one[i]), 1e-12) << i;
    ASSERT_LT(length(both[one.size() + i] - other[i]), 1e-12) << i;
  }
}

TEST(Corrector, OfBodiesOnALineOrOfTwoParticlesStaysFinite) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const Corrector corrector : {Corrector::Inertia, Corrector::Paper, Corrector::Off})
      for (const int unknowns : {2, 3, 10}) {
        BodySpec chain = sprung_chain(unknowns, true);
        chain.spin = {5, 0, 1}, chain.constraints[0].parameter = 0.8;
        Scene scene = desbrun_scene({chain}, 1e4, precision);
        scene.solver.desbrun.corrector = corrector;
        Simulation simulation(scene, {.threads = 1});
        for (int step = 0; step < 30; ++step) ASSERT_NO_THROW(simulation.step());
      }
}

// v_n = v - n dt g, x_n = x + dt (v_1 + ... + v_n): every particle falls as if it had no springs.
TEST(FreeFall, OfASpringBodyIsExact) {
  BodySpec sheet = sprung_sheet(8);
  sheet.velocity = {1, 2, 0.5};
  for (const auto kind : {FilterKind::Dense, FilterKind::Sparse})
    for (const bool internal_only : {false, true})
      for (const int refinements : {0, 4})
        for (const auto precision : {Precision::Float, Precision::Double}) {
          Scene scene = desbrun_scene({sheet}, 1e4, precision);
          scene.solver.desbrun.filter = kind, scene.solver.desbrun.filter_external_forces = !internal_only;
          scene.solver.desbrun.refinement_iterations = refinements;
          Simulation simulation(scene, {.threads = 1});
          const std::vector<Vec3> start = simulation.positions();
          const int n = 60;
          for (int step = 0; step < n; ++step) simulation.step();
          const std::vector<Vec3> now = simulation.positions();
          const double dt = scene.solver.dt, fallen = 9.81 * dt * dt * n * (n + 1) / 2;
          // 60 steps round positions of up to 4 m and velocities of up to 8 m/s (which act for 0.5 s on average), at
          // worst all in the same direction. Springs respond to the rounding of the positions, and keep the particles
          // together.
          const double rounding = 60 * 8 * (precision == Precision::Float ? 1.2e-7 : 2.3e-16);
          for (std::size_t i = 0; i < now.size(); ++i) {
            ASSERT_NEAR(now[i][0], start[i][0] + 1, rounding) << i;
            ASSERT_NEAR(now[i][1], start[i][1] + 2 - fallen, rounding) << i;
            ASSERT_NEAR(now[i][2], start[i][2] + 0.5, rounding) << i;
          }
        }
}

TEST(FilteredFreeBody, GoesTheSameWayWhetherItsWeightIsFilteredOrNot) {
  Scene scene = desbrun_scene({ellipsoid()}, 1e4, Precision::Float);
  const std::uint64_t all = after(scene, 0.2).state_hash();
  scene.solver.desbrun.filter_external_forces = false;
  EXPECT_EQ(after(scene, 0.2).state_hash(), all);
  scene.bodies[0].pins = {ListPin{{0}}};
  const std::uint64_t pinned = after(scene, 0.2).state_hash();
  scene.solver.desbrun.filter_external_forces = true;
  EXPECT_NE(after(scene, 0.2).state_hash(), pinned);
}

}  // namespace
}  // namespace malha
