// Levels: large bodies are as stiff as small ones, and what they do not help pays nothing.
#include "host/model/levels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/simulation.h"
#include "host/solver/solver.h"
#include "tests/irregular_mesh.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A sheet of 2 x 2 m and 1 kg in the plane y = 0, hung by its row z = 0.
Scene hung_sheet(const Shape& shape, int levels, int every = 2, Precision precision = Precision::Float) {
  BodySpec body;
  body.name = "sheet";
  body.shape = shape;
  body.mass = 1;
  body.constraints = {stiff("distance", std::holds_alternative<GridShape>(shape)
                                            ? std::vector<std::string>{"edges", "shear"}
                                            : std::vector<std::string>{"edges"})};
  body.pins = {BoxPin{{-1, -1, -1e-9}, {3, 1, 1e-9}}};
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10, precision);
  scene.solver.levels = levels, scene.solver.levels_every = every;
  return scene;
}
GridShape sheet_of(int side) { return {{2, 2}, {side - 1, side - 1}}; }

Measures after_a_second(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 1);
  return simulation.measure();
}

/// Plain sweeps: 0.0075, 0.036; with levels it was 0.0011 and 0.0019.
TEST(Levels, StretchDoesNotGrowWithTheMesh) {
  EXPECT_LT(after_a_second(hung_sheet(sheet_of(46), kMostLevels)).strain_rms, 0.003);
  const Measures fine = after_a_second(hung_sheet(sheet_of(100), kAutoLevels));
  EXPECT_LT(fine.strain_rms, 0.003);
  EXPECT_LT(fine.strain_max, 0.05);
  EXPECT_GT(after_a_second(hung_sheet(sheet_of(100), 0)).strain_rms, 0.03);
}

/// Whatever sways to the other side has less energy than at the start, which is 0 there.
TEST(Levels, GainNoEnergy) {
  for (const auto precision : {Precision::Float, Precision::Double}) {
    const Scene scene = hung_sheet(sheet_of(90), kAutoLevels, 2, precision);
    Simulation simulation(scene, {.threads = 1});
    ASSERT_FALSE(simulation.solver().facts().levels.empty());
    for (int step = 0; step < 90; ++step) {
      simulation.step();
      ASSERT_LT(simulation.measure().energy(), 0.002) << step;  // J; rounding of float, see stability_test.cpp
    }
  }
}

TEST(Levels, HoldIrregularMeshesToo) {
  const TemporaryFolder folder;
  for (const unsigned seed : {1U, 2U}) {
    const MeshFile mesh{folder.write("sheet.obj", irregular_obj(2, 2, 70, 70, 0.25, seed))};
    const Measures held = after_a_second(hung_sheet(mesh, kAutoLevels));
    EXPECT_LT(held.strain_rms, 0.006);
    EXPECT_GT(after_a_second(hung_sheet(mesh, 0)).strain_rms, 5 * held.strain_rms);
  }
}

/// The sag of a sheet that hangs at rest, against 200 substeps of plain sweeps: 6 % (plain sweeps of 10: 300 %).
TEST(Levels, ComplianceStretchesAsManySubstepsDo) {
  const auto stretch = [](int substeps, int levels) {
    Scene scene = hung_sheet(sheet_of(33), levels);
    scene.bodies[0].constraints = {compliant("distance", 1.0 / 300, {"edges", "shear"})};
    scene.bodies[0].transform.axis = {1, 0, 0}, scene.bodies[0].transform.degrees = 90;
    scene.bodies[0].pins = {RowPin{}};
    scene.bodies[0].damping = 0.2;
    scene.solver.substeps = substeps;
    Simulation simulation(scene, {.threads = 1});
    run_for(simulation, scene, 3);
    const std::vector<Vec3> x = simulation.positions();
    double end = 0;
    for (int i = 0; i < 33; ++i) end -= x[32 * 33 + i][1] / 33;
    return end / 2 - 1;
  };
  const double true_stretch = stretch(200, 0), plain = stretch(10, 0), levels = stretch(10, kMostLevels);
  EXPECT_NEAR(levels, true_stretch, 0.15 * true_stretch);
  EXPECT_GT(plain, 1.5 * true_stretch);
}

TEST(Levels, KeepTheMomentumOfAFreeBody) {
  BodySpec body = tumbling_ellipsoid(3, {stiff("distance", {"edges"})});
  for (const int levels : {0, kMostLevels}) {
    Scene scene = scene_of({body}, {}, 1.0 / 60, 10);
    scene.solver.levels = levels;
    Simulation simulation(scene, {.threads = 1});
    EXPECT_EQ(simulation.solver().facts().levels.empty(), levels == 0);
    const Measures before = simulation.measure();
    run_for(simulation, scene, 0.5);
    const Measures after = simulation.measure();
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(after.momentum[k], before.momentum[k], 1e-12);  // rounding of double
      EXPECT_NEAR(after.angular_momentum[k], before.angular_momentum[k], 0.02 * length(before.angular_momentum));
    }
  }
}

/// Curved at rest, or folded: nothing pulls, so nothing moves but what rounding of the lengths does.
TEST(Levels, LeaveWhatIsAtRestAlone) {
  BodySpec ball, box;
  ball.shape = SphereShape{0.5, 4}, box.shape = BoxShape{{1, 1, 1}, {16, 16, 16}};
  for (BodySpec& body : {std::ref(ball), std::ref(box)}) {
    body.name = "body", body.mass = 1, body.constraints = {stiff("distance", {"edges"})};
    Scene scene = scene_of({body}, {}, 1.0 / 60, 10);
    scene.solver.levels = kMostLevels;
    Simulation simulation(scene, {.threads = 1});
    ASSERT_GE(simulation.solver().facts().levels.size(), 3U);
    const std::vector<Vec3> before = simulation.positions();
    run_for(simulation, scene, 0.2);
    const std::vector<Vec3> after = simulation.positions();
    for (std::size_t i = 0; i < after.size(); ++i) EXPECT_LT(length(after[i] - before[i]), 1e-9);
  }
}

/// A sheet that is bent to a half pipe at rest, unrolled: none of its coarse constraints may be in the way, nor much
/// longer than what it stands for. `place`: of the unrolled sheet.
TEST(Levels, AreAsLongAsTheSheetIsUnrolled) {
  const int side = 49;
  const double radius = 2 / kPi;
  const TemporaryFolder folder;
  std::string obj;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const double angle = kPi * i / (side - 1), z = 2.0 * j / (side - 1);
      obj += "v " + std::to_string(radius * std::cos(angle)) + " " + std::to_string(radius * std::sin(angle)) + " " +
             std::to_string(z) + "\n";
    }
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      const int a = j * side + i + 1;
      obj += "f " + std::to_string(a) + " " + std::to_string(a + side) + " " + std::to_string(a + side + 1) + " " +
             std::to_string(a + 1) + "\n";
    }
  Scene scene = hung_sheet(MeshFile{folder.write("pipe.obj", obj)}, kMostLevels);
  scene.bodies[0].constraints = {stiff("distance", {"edges", "shear"})};
  const Model model = build_model(scene);
  const std::vector<Level> levels = make_levels(model, model.w);
  ASSERT_GE(levels.size(), 4U);
  std::vector<Vec3> flat;  // of the finer particles, in their order
  for (const int user : model.user_of)
    flat.push_back({2.0 * (user % side) / (side - 1), 0, 2.0 * (user / side) / (side - 1)});
  for (std::size_t l = 0; l < 4; ++l) {
    const Level& level = levels[l];
    std::vector<Vec3> coarse(level.model.x.size());
    for (int rank = 0; rank < level.up.count(); ++rank) {
      Vec3 mean{};
      for (int k = level.up.begin[rank]; k < level.up.begin[rank + 1]; ++k)
        for (int d = 0; d < 3; ++d) mean[d] += level.up.weight[k] * flat[level.up.of[k]][d];
      coarse[level.particle[rank]] = mean;
    }
    for (const ConstraintSet& set : level.model.sets)
      for (int c = 0; c < set.count(); ++c) {
        const double unrolled = length(coarse[set.particles[2 * c]] - coarse[set.particles[2 * c + 1]]);
        EXPECT_GT(set.rest[c], 0.98 * unrolled) << "level " << l;
        EXPECT_LT(set.rest[c], 1.1 * unrolled) << "level " << l;
      }
    flat = coarse;
  }
}

TEST(Levels, AreTheSameBitsOnAnyThreads) {
  for (const bool contact : {false, true}) {
    Scene scene = hung_sheet(sheet_of(70), kAutoLevels);
    if (contact) {
      EnvironmentSpec ball;
      ball.name = "ball", ball.shape = SphereShape{0.4, 3}, ball.transform.translate = {1, -0.5, 1.2};
      scene.environment = {ball};
    }
    std::uint64_t hash = 0;
    for (const int threads : {1, 2, 3, 8}) {
      Simulation simulation(scene, {.threads = threads});
      for (int step = 0; step < 8; ++step) simulation.step();
      if (threads == 1) hash = simulation.state_hash();
      EXPECT_EQ(simulation.state_hash(), hash) << threads << " threads";
    }
  }
}

TEST(Levels, GoOnFromASavedStateBitByBit) {
  const Scene scene = hung_sheet(sheet_of(70), kAutoLevels, 3);
  Simulation whole(scene, {.threads = 1}), first(scene, {.threads = 1}), second(scene, {.threads = 1});
  for (int step = 0; step < 6; ++step) whole.step();
  for (int step = 0; step < 3; ++step) first.step();
  const TemporaryFolder folder;
  first.save_checkpoint((folder / "state").string());
  second.load_checkpoint((folder / "state").string());
  for (int step = 0; step < 3; ++step) second.step();
  EXPECT_EQ(second.state_hash(), whole.state_hash());
}

/// Once its pins have let go a sheet falls as a stone does: its levels no longer hang on anything.
TEST(Levels, FallWhenTheirPinsLetGo) {
  Scene scene = hung_sheet(sheet_of(70), kAutoLevels, 2, Precision::Double);
  scene.bodies[0].pins[0].until = 0.2;
  Simulation simulation(scene, {.threads = 1});
  ASSERT_FALSE(simulation.solver().facts().levels.empty());
  run_for(simulation, scene, 0.25);
  const double before = simulation.measure().momentum[1];
  run_for(simulation, scene, 0.25);
  EXPECT_NEAR(simulation.measure().momentum[1], before - 1 * kG * 0.25, 1e-9);  // 1 kg; rounding
}

/// To the same sheet after 120 substeps of plain sweeps: 0.08 m with levels, 0.25 without.
TEST(Levels, HoldASheetThatHangsOverABall) {
  const auto hung = [](int substeps, int levels) {
    Scene scene = hung_sheet(sheet_of(64), levels);
    EnvironmentSpec ball;
    ball.name = "ball", ball.shape = SphereShape{0.4, 3}, ball.transform.translate = {1, -1.1, 0.3};
    scene.environment = {ball};
    scene.solver.substeps = substeps;
    return scene;
  };
  const Measures levels = after_a_second(hung(10, kAutoLevels)), plain = after_a_second(hung(10, 0));
  EXPECT_LT(levels.strain_rms, 0.02);
  EXPECT_LT(levels.strain_rms, plain.strain_rms);
  EXPECT_LE(levels.penetration_max, 1e-6);
}

/// Small bodies, bodies that nothing holds, and other constraints than distance.
TEST(Levels, AreNotThereWhereTheyHelpNobody) {
  Scene small = hung_sheet(sheet_of(40), kAutoLevels), loose = hung_sheet(sheet_of(70), kAutoLevels);
  loose.bodies[0].pins.clear();
  for (Scene* scene : {&small, &loose}) {
    Simulation automatic(*scene, {.threads = 1});
    scene->solver.levels = 0;
    Simulation off(*scene, {.threads = 1});
    EXPECT_TRUE(automatic.solver().facts().levels.empty());
    EXPECT_EQ(automatic.solver().facts().level_bytes, 0U);
    for (int step = 0; step < 3; ++step) automatic.step(), off.step();
    EXPECT_EQ(automatic.state_hash(), off.state_hash());
  }
}

/// Each particle follows what reproduces its place in the flat sheet, apart from the rim, and as many as 4.
TEST(Levels, ParticlesFollowThoseAroundThem) {
  const TemporaryFolder folder;
  const Scene scene = hung_sheet(MeshFile{folder.write("sheet.obj", irregular_obj(2, 2, 40, 40, 0.25, 5))}, 1);
  const Model model = build_model(scene);
  const Level level = make_levels(model, model.w).front();
  double squares = 0;
  for (int i = 0; i < level.down.count(); ++i) {
    if (model.w[i] == 0) {
      EXPECT_EQ(level.down.begin[i], level.down.begin[i + 1]);  // pins follow nothing
      continue;
    }
    Vec3 mean{};
    double sum = 0;
    for (int k = level.down.begin[i]; k < level.down.begin[i + 1]; ++k) {
      const Vec3& at = level.model.x[level.particle[level.down.of[k]]];
      sum += level.down.weight[k];
      for (int d = 0; d < 3; ++d) mean[d] += level.down.weight[k] * at[d];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_LE(level.down.begin[i + 1] - level.down.begin[i], 4);
    const double off = length(mean - model.x[i]);
    squares += off * off / level.down.count();
  }
  EXPECT_LT(std::sqrt(squares), 0.25 * 2 / 40);  // a quarter of an edge
}

TEST(Levels, OfAScenesSolverAreReadAndRefused) {
  const auto with = [](const std::string& solver) {
    return parse_scene(R"({"name": "s", "solver": {"type": "pbd")" + solver +
                           R"(}, "bodies": [{"name": "b", "shape": {"grid": {"size": [1, 1], "cells": [1, 1]}},
                             "mass": 1, "constraints": [{"type": "distance"}]}], "duration": 1})",
                       "s.json", "")
        .solver;
  };
  EXPECT_EQ(with("").levels, kAutoLevels);
  EXPECT_EQ(with("").levels_every, 2);
  EXPECT_EQ(with(R"(, "levels": "off")").levels, 0);
  EXPECT_EQ(with(R"(, "levels": 3, "levels_every": 1)").levels, 3);
  EXPECT_NE(refusal([&] { with(R"(, "levels": "many")"); }).find("/solver/levels: found"), std::string::npos);
  EXPECT_NE(refusal([&] { with(R"(, "levels": 0)"); }).find("/solver/levels: found"), std::string::npos);
  for (const char* every : {R"(, "levels_every": 0)", R"(, "levels_every": 4)"})
    EXPECT_NE(refusal([&] { with(every); }).find("/solver/levels_every: found"), std::string::npos);
}

}  // namespace
}  // namespace malha
