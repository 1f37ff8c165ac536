// SPDX-License-Identifier: Apache-2.0
// Forces on particles that a program sets between steps, and copies of the state into its memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/solver/solver.h"
#include "host/solver/step_plan.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// A sheet of 0.3 kg that hangs from two corners; `type`: of the solver.
Scene sheet_by(const std::string& type, const Vec3& gravity, Precision precision = Precision::Double) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.3, sheet.shape = GridShape{{1, 1}, {12, 12}};
  sheet.pins = {ListPin{{0, 12}}};
  sheet.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
  Scene scene = scene_of({sheet}, gravity, 0.01, 5, precision);
  scene.solver.type = type;
  return scene;
}

/// The weight of each particle, N.
std::vector<Vec3> weights_of(const Simulation& simulation, const Vec3& gravity) {
  std::vector<Vec3> all;
  for (const double w : simulation.inverse_masses()) {
    const double mass = w > 0 ? 1 / w : 0;
    all.push_back({mass * gravity[0], mass * gravity[1], mass * gravity[2]});
  }
  return all;
}

double farthest_apart(const Simulation& a, const Simulation& b) {
  double most = 0;
  const std::vector<Vec3> x = a.positions(), y = b.positions();
  for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, length(x[i] - y[i]));
  return most;
}

TEST(SetForces, AccelerateByTheirMassInEverySubstep) {
  for (const int substeps : {1, 7}) {
    BodySpec other = particle({0, 1, 0});
    other.name = "other";
    Simulation simulation(scene_of({particle({0, 0, 0}, {1, 0, 0}, 2), other}, {0, 0, 0}, 0.1, substeps),
                          {.threads = 1});
    simulation.set_forces({{0, 3, 0}, {0, 0, 0}});
    for (int step = 0; step < 10; ++step) simulation.step();
    EXPECT_NEAR(length(simulation.velocities()[0] - Vec3{1, 1.5, 0}), 0, 1e-12);
    EXPECT_EQ(simulation.velocities()[1], (Vec3{0, 0, 0}));
    simulation.set_forces({});
    for (int step = 0; step < 10; ++step) simulation.step();
    EXPECT_NEAR(length(simulation.velocities()[0] - Vec3{1, 1.5, 0}), 0, 1e-12) << "none acts any more";
  }
}

class ForcesBy : public testing::TestWithParam<std::string> {};

TEST_P(ForcesBy, TheWeightOfEachParticleIsAsGoodAsGravity) {
  Simulation by_gravity(sheet_by(GetParam(), kEarth), {.threads = 1});
  Simulation by_forces(sheet_by(GetParam(), {0, 0, 0}), {.threads = 1});
  by_forces.set_forces(weights_of(by_forces, kEarth));
  for (int step = 0; step < 50; ++step) by_gravity.step(), by_forces.step();
  EXPECT_GT(length(by_gravity.positions().back() - Simulation(sheet_by(GetParam(), kEarth)).positions().back()), 0.1);
  // Desbrun's filter treats gravity as it does forces only on free bodies, and rounds both differently.
  EXPECT_LT(farthest_apart(by_gravity, by_forces), GetParam() == "pbd" ? 1e-9 : 0.02);
}

TEST_P(ForcesBy, AgainstTheWeightLeaveAFreeBodyWhereItIs) {
  for (const Precision precision : {Precision::Double, Precision::Float}) {
    Scene scene = sheet_by(GetParam(), kEarth, precision);
    scene.bodies[0].pins.clear();
    Simulation simulation(scene, {.threads = 1}), start(scene, {.threads = 1});
    simulation.set_forces(weights_of(simulation, {0, kG, 0}));
    for (int step = 0; step < 100; ++step) simulation.step();
    EXPECT_LT(farthest_apart(simulation, start), precision == Precision::Double ? 1e-9 : 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(, ForcesBy, testing::Values("pbd", "desbrun"),
                         [](const auto& tested) { return tested.param; });

TEST(SetForces, ArePartOfAStepOnlyWhereTheyAreSet) {
  Scene free = sheet_by("pbd", kEarth);
  free.bodies[0].pins.clear();
  for (const Scene& scene : {sheet_by("pbd", kEarth), sheet_by("desbrun", kEarth), free}) {
    Simulation simulation(scene, {.threads = 1});
    const auto has_stage = [&] {
      return std::ranges::count(simulation.solver().step_plan().substep, Stage::ApplyForces) == 1;
    };
    const auto by_solves = [&] { return simulation.solver().step_plan().solves_apply_forces; };
    EXPECT_FALSE(has_stage() || by_solves());
    simulation.set_forces(weights_of(simulation, {0, 0, 1}));
    simulation.step();
    EXPECT_NE(has_stage(), by_solves()) << "once";
    simulation.set_forces({});
    simulation.step();
    EXPECT_FALSE(has_stage() || by_solves());
  }
  Simulation fused(sheet_by("pbd", kEarth), {.threads = 1});
  fused.set_forces(weights_of(fused, {0, 0, 1}));
  EXPECT_TRUE(fused.solver().step_plan().solves_apply_forces);
  EXPECT_EQ(fused.solver().step_plan().solves, PatchSolves::ByStep) << "as without forces";
}

// A step with a callback has passes of their own for the forces, the prediction and the update of the state.
TEST(SetForces, HaveTheSameBitsInAPatchSolveAsInAPass) {
  const auto nothing = [](int, double) {};
  for (const Precision precision : {Precision::Double, Precision::Float})
    for (const std::string kind : {"hung", "levels", "wind", "damped", "free", "two iterations", "above a ball"}) {
      SCOPED_TRACE(kind);
      Scene scene = sheet_by("pbd", kEarth, precision);
      scene.solver.levels = 0;
      if (kind == "levels") scene.solver.levels = 2, scene.solver.levels_interval = 2;
      if (kind == "wind") scene.wind.emplace().drag = 1e-3, scene.wind->velocity = {1, 0, 2};
      if (kind == "damped") scene.bodies[0].damping = 0.5;
      if (kind == "free") scene.bodies[0].pins.clear();
      if (kind == "two iterations") scene.solver.iterations = 2;
      if (kind == "above a ball") {  // onto which it falls after steps without contact tests
        EnvironmentSpec ball;
        ball.name = "ball", ball.shape = SphereShape{0.2, 3}, ball.transform.translate = {0.5, -0.4, 0.5};
        scene.environment = {ball};
      }
      const SimulationOptions options{.threads = 1, .interactive = true};
      Simulation in_solves(scene, options), in_passes(scene, options), without(scene, options);
      std::vector<Vec3> forces = weights_of(in_solves, {3, 1, -2});
      for (std::size_t i = 0; i < forces.size(); ++i) forces[i][1] *= static_cast<double>(i % 7);
      in_solves.set_forces(forces), in_passes.set_forces(forces);
      for (int step = 0; step < 20; ++step) in_solves.step(), in_passes.step(nothing), without.step();
      EXPECT_EQ(in_solves.state_hash(), in_passes.state_hash());
      EXPECT_EQ(in_solves.solver().step_plan().skips_contacts, kind == "above a ball");
      EXPECT_NE(in_solves.state_hash(), without.state_hash());
    }
}

TEST(SetForces, MayBeSetInTheCallbackOfAStep) {
  Simulation simulation(scene_of({particle({0, 0, 0})}, {0, 0, 0}, 1, 4), {.threads = 1, .interactive = true});
  simulation.step([&](int substep, double) {
    simulation.set_forces(substep == 2 ? std::vector<Vec3>{{1, 0, 0}} : std::vector<Vec3>{});
  });
  EXPECT_NEAR(simulation.velocities()[0][0], 0.25, 1e-12) << "in the third of four substeps";
}

TEST(SetForces, StayAsTheyAreWhereTheLayoutChanges) {
  const Scene scene = sheet_by("pbd", {0, 0, 0});
  Simulation simulation(scene, {.threads = 1}), alike(scene, {.threads = 1});
  simulation.set_forces(weights_of(simulation, kEarth)), alike.set_forces(weights_of(alike, kEarth));
  std::vector<int> pins = simulation.pins();
  pins.push_back(168);
  simulation.set_pins(pins);
  alike.set_pins(pins), alike.set_forces(weights_of(simulation, kEarth));
  simulation.step(), alike.step();
  EXPECT_LT(farthest_apart(simulation, alike), 1e-12);
  EXPECT_LT(simulation.velocities()[80][1], -0.05) << "they act";
}

TEST(SetForces, RefuseWhatIsNoForceAParticle) {
  Simulation simulation(scene_of({particle({0, 0, 0})}, {0, 0, 0}, 1), {.threads = 1});
  EXPECT_EQ(refusal([&] {
              simulation.set_forces({{0, 0, 0}, {0, 0, 0}});
            }),
            "forces: found 2 rows; allowed: 1, one a particle");
  EXPECT_EQ(refusal([&] {
              simulation.set_forces({{0, NAN, 0}});
            }),
            "forces: row 0: found nan; allowed: numbers up to 1e18");
}

TEST(CopiesOfTheState, AreTheValuesOfTheListsWhateverTheStride) {
  for (const Precision precision : {Precision::Double, Precision::Float}) {
    const Simulation simulation = after(sheet_by("pbd", kEarth, precision), 0.2);
    const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
    for (const std::size_t stride : {3, 8}) {
      std::vector<float> x_in_float(x.size() * stride, 7), v_in_float = x_in_float;
      std::vector<double> x_in_double(x.size() * stride, 7), v_in_double = x_in_double;
      simulation.copy_positions(x_in_float.data(), stride), simulation.copy_positions(x_in_double.data(), stride);
      simulation.copy_velocities(v_in_float.data(), stride), simulation.copy_velocities(v_in_double.data(), stride);
      for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t k = 0; k < stride; ++k) {
          const std::size_t at = i * stride + k;
          EXPECT_EQ(x_in_double[at], k < 3 ? x[i][k] : 7);
          EXPECT_EQ(v_in_double[at], k < 3 ? v[i][k] : 7);
          EXPECT_EQ(x_in_float[at], k < 3 ? static_cast<float>(x[i][k]) : 7);
          EXPECT_EQ(v_in_float[at], k < 3 ? static_cast<float>(v[i][k]) : 7);
        }
    }
  }
  const Simulation simulation(sheet_by("pbd", kEarth), {.threads = 1});
  std::vector<float> to(3 * 169);
  EXPECT_EQ(refusal([&] { simulation.copy_positions(to.data(), 2); }),
            "copy: stride: found 2; allowed: 3 numbers a particle, or more");
}

TEST(CopiesOfTheState, HaveUnitNormalsOfTheFaces) {
  BodySpec ball;
  ball.name = "ball", ball.mass = 1, ball.shape = SphereShape{0.5, 3};
  const Simulation simulation(scene_of({ball, particle({3, 0, 0})}, {0, 0, 0}, 0.1), {.threads = 1});
  const std::vector<Vec3> x = simulation.positions();
  std::vector<double> normals(4 * x.size(), 7);
  simulation.copy_normals(normals.data(), 4);
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    const Vec3 normal{normals[4 * i], normals[4 * i + 1], normals[4 * i + 2]};
    EXPECT_NEAR(length(normal), 1, 1e-12);
    EXPECT_LT(length(normal - Vec3{2 * x[i][0], 2 * x[i][1], 2 * x[i][2]}), 0.05) << "outwards";
    EXPECT_EQ(normals[4 * i + 3], 7);
  }
  EXPECT_EQ(normals[4 * x.size() - 4], 0) << "a particle without a face";
}

}  // namespace
}  // namespace malha
