// SPDX-License-Identifier: Apache-2.0
// Promises of filtered bending: when it is chosen, the same bits everywhere, and pins, handles and tears that change
// what its matrix contains.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/model/model.h"
#include "host/report/warnings.h"
#include "host/solver/solver.h"
#include "tests/constraints/sheet_statics.h"
#include "tests/filter/clamped_strip.h"
#include "tests/parallel/blocks_solvers.h"
#include "tests/support.h"

namespace malha {
namespace {

TEST(BendingMethod, IsFilteredWhereProjectionsAreTooSoftAndFoldsDoNotTurnTooFast) {
  const auto methods = [](const BodySpec& body, BendingMethod bending, int substeps) {
    Scene scene = scene_of({body}, kEarth, 1.0 / 60, substeps);
    scene.solver.bending = bending;
    const Model model = build_model(scene);
    const auto lines = warnings(model);
    const auto soft = std::ranges::count_if(lines, [](const std::string& line) { return has(line, "deforms"); });
    return std::pair(model.stencils.size(), static_cast<std::size_t>(soft));
  };
  const BodySpec strip = clamped_strip(24, 0.1);
  EXPECT_EQ(methods(strip, BendingMethod::Auto, 10), std::pair(std::size_t(1), std::size_t(0)));
  EXPECT_EQ(methods(strip, BendingMethod::Projected, 10), std::pair(std::size_t(0), std::size_t(1)));
  EXPECT_EQ(methods(strip, BendingMethod::Auto, 1000), std::pair(std::size_t(0), std::size_t(0)));
  EXPECT_EQ(methods(strip, BendingMethod::Filtered, 1000), std::pair(std::size_t(1), std::size_t(0)));
  BodySpec k = strip;
  k.constraints[1] = stiff("bending", {}, 0.5);
  EXPECT_EQ(methods(k, BendingMethod::Filtered, 10).first, 0u) << "of a stiffness";
  // A stiff shell whose folds are sharp stays projected, and is said to be soft.
  BodySpec shell = tumbling_ellipsoid(2, {stiff("distance", {"edges"}), bending_of("bending", 1e4)});
  EXPECT_EQ(methods(shell, BendingMethod::Auto, 10), std::pair(std::size_t(0), std::size_t(1)));
  Scene sharp = scene_of({shell}, kEarth, 1.0 / 60, 10);
  sharp.solver.bending = BendingMethod::Filtered;
  const auto warned = warnings(build_model(sharp));
  EXPECT_TRUE(std::ranges::any_of(warned, [](const auto& line) { return has(line, "gain energy"); }));
  shell.constraints[1] = bending_of("bending", 1);
  EXPECT_EQ(methods(shell, BendingMethod::Auto, 10).first, 1u);
}

// Folds along its edges, a twentieth of its hinges, would turn too fast in the filter: it would gain twice its energy.
TEST(BendingMethod, OfAStiffBoxThatFallsAddsNoEnergy) {
  BodySpec box;
  box.name = "box", box.shape = BoxShape{{0.6, 0.6, 0.6}, {{14, 14, 14}}}, box.density = 0.3;
  box.transform.translate = {0, 1.4, 0}, box.transform.axis = {1, 0.4, 0.2}, box.transform.degrees = 40;
  box.constraints = {stiff("distance", {"edges", "shear"}), bending_of("bending", 1e4)};
  Scene scene = scene_of({box}, kEarth, 1.0 / 60, 10);
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = BoxShape{{9, 1, 9}, {{1, 1, 1}}}, ground.transform.translate = {0, -0.5, 0};
  scene.environment = {ground};
  Simulation simulation(scene, {.threads = 1});
  const auto energy = [&] { return simulation.measure().kinetic + simulation.measure().potential; };
  const double start = energy();
  double most = start;
  for (int step = 0; step < 90; ++step) simulation.step(), most = std::max(most, energy());
  EXPECT_LT(most, start + 1e-3 * std::abs(start));
}

// Rounding leaves a filter the sag that it has in double, or `run` warns of it.
TEST(BendingMethod, InFloatIsThatOfDoubleOrSaysThatItIsTooStiff) {
  for (const double D : {1.0, 1e2, 1e4, 1e5, 1e7, 1e9}) {
    BodySpec strip = clamped_strip(16, D);
    Scene scene = scene_of({strip}, kEarth, 1.0 / 60, 10, Precision::Float);
    const auto lines = warnings(build_model(scene));
    const bool is_warned = std::ranges::any_of(
        lines, [](const std::string& line) { return has(line, "too stiff for a filter") || has(line, "deforms"); });
    const Simulation in_float = after(scene, 0.5);
    scene.solver.precision = Precision::Double;
    const Simulation in_double = after(scene, 0.5);
    const double off = length(in_float.positions().back() - in_double.positions().back());
    EXPECT_TRUE(is_warned || off < 2e-3) << D << ": " << off;
    EXPECT_EQ(is_warned, D > 1e4) << D;
  }
}

// Hinges of cells that are 40 times as short as their neighbours have the compliances of projected ones.
TEST(BendingMethod, OfGradedCellsKeepsTheirRigidity) {
  for (const char* type : {"bending", "isometric_bending"}) {
    std::vector<double> z{0};
    for (int i = 0; i < 30; ++i) z.push_back(z.back() + (10 <= i && i < 20 ? 0.025 / 40 : 0.025));
    BodySpec strip;
    strip.name = "strip", strip.density = 0.2, strip.constraints = {bending_of(type, 1e-4)};
    strip.shape = quads_between({0, 0.025, 0.05}, z);
    Scene scene = scene_of({strip}, kEarth, 1.0 / 60, 10, Precision::Float);
    scene.solver.bending = BendingMethod::Filtered;
    const Model filtered = build_model(scene);
    scene.solver.bending = BendingMethod::Projected;
    const Model projected = build_model(scene);
    ASSERT_EQ(filtered.stencils.size(), 1u);
    ASSERT_EQ(filtered.stencils[0].count(), projected.sets[0].count());
    for (int c = 0; c < filtered.stencils[0].count(); ++c)
      EXPECT_NEAR(filtered.stencils[0].alpha(c) / projected.sets[0].alpha(c), 1, 1e-12) << type << ", hinge " << c;
  }
}

/// A scene in which filtered bodies have what a scene may have.
Scene full_of_filtered(Precision precision) {
  BodySpec sheet = clamped_strip(16, 1e-2);
  sheet.name = "sheet", sheet.transform.translate = {0, 1, 0};
  BodySpec plate = clamped_strip(12, 2e-3, "plate");
  plate.name = "plate", plate.transform.translate = {1, 1.2, 0}, plate.pins[0].release_time = 0.1;
  BodySpec ball = tumbling_ellipsoid(2, {compliant("distance", 1e-5, {"edges"}), bending_of("bending", 1e-3)});
  ball.transform.translate = {3, 1.1, 0};
  ConstraintSpec pressure = stiff("pressure");
  pressure.parameter = 1.1, ball.constraints.push_back(pressure);
  Scene scene = scene_of({sheet, plate, ball}, kEarth, 1.0 / 60, 4, precision);
  scene.self_collision = SelfCollision{};
  scene.self_collision->thickness = 0.004;
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = GridShape{{80, 80}, {1, 1}}, ground.transform.translate = {-40, 0, -40};
  ground.sides = Sides::OneSided, ground.friction = 0.3;
  scene.environment = {ground};
  return scene;
}

TEST(FilteredBending, HasTheSameBitsOnThreadsInstructionSetsAndBlocks) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const Scene scene = full_of_filtered(precision);
    ASSERT_EQ(build_model(scene).stencils.size(), 3u);
    const std::uint64_t one = after(scene, 0.25).state_hash();
    for (const std::string& set : instruction_sets())
      EXPECT_EQ(after(scene, 0.25, {.threads = 2, .instructions = set}).state_hash(), one) << set;
#if defined(TESTS_BLOCKS)
    EXPECT_EQ(hash_on_blocks(scene, 15, {64}), one);
#endif
  }
}

TEST(FilteredBending, GoesOnFromACheckpointWithTheSameBits) {
  for (const double when : {0.05, 0.2}) {  // before and after the release
    const Scene scene = full_of_filtered(Precision::Float);
    Simulation whole(scene, {.threads = 1}), part(scene, {.threads = 1});
    run_for(whole, scene, when);
    part.restore_state(whole.save_state());
    run_for(whole, scene, 0.1);
    run_for(part, scene, 0.1);
    EXPECT_EQ(whole.state_hash(), part.state_hash()) << when;
  }
}

TEST(FilteredBending, OfPinsThatAreReleasedIsThatOfABodyWithoutThem) {
  BodySpec body = clamped_strip(12, 1e-2);
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 5);
  scene.bodies[0].pins[0].release_time = 0.05;
  scene.bodies[0].constraints[1] = compliant("bending", 10);  // hinges of a material know which pins stay
  Simulation released = after(scene, 0.05);
  scene.bodies[0].pins.clear();
  Simulation free(scene, {.threads = 1});
  free.set_positions(released.positions()), free.set_velocities(released.velocities());
  for (int step = 0; step < 20; ++step) released.step(), free.step();
  double apart = 0;
  for (std::size_t i = 0; i < free.positions().size(); ++i)
    apart = std::max(apart, length(free.positions()[i] - released.positions()[i]));
  EXPECT_LT(apart, 1e-6) << "constraints in another order";
}

TEST(FilteredBending, OfAHeldParticleLeavesItWhereItIs) {
  Scene scene = scene_of({clamped_strip(12, 1e-2)}, kEarth, 1.0 / 60, 5);
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  const int held = static_cast<int>(simulation.positions().size()) - 1;
  const Vec3 at = simulation.positions()[held];
  simulation.hold(held);
  run_for(simulation, scene, 0.5);
  EXPECT_EQ(simulation.positions()[held], at);
  simulation.release(held);
  run_for(simulation, scene, 0.5);
  EXPECT_LT(simulation.positions()[held][1], at[1] - 0.01);
}

TEST(FilteredBending, OfATornSheetIsThatOfItsParts) {
  Scene scene = scene_of({clamped_strip(12, 1e-2)}, kEarth, 1.0 / 60, 5);
  scene.bodies[0].tear = Tear{0.5};
  Simulation simulation(scene, {.threads = 1});
  const std::size_t before = simulation.positions().size();
  std::vector<Vec3> v(before, Vec3{0, 0, 0});
  for (std::size_t i = before / 2; i < before; ++i) v[i] = {0, 0, 60};
  simulation.set_velocities(v);
  run_for(simulation, scene, 0.5);
  EXPECT_GT(simulation.positions().size(), before);
  EXPECT_FALSE(simulation.model().stencils.empty());
}

}  // namespace
}  // namespace malha
