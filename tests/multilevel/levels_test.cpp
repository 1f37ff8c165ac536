// SPDX-License-Identifier: Apache-2.0
// Levels: large bodies are as stiff as small ones, and bodies that levels do not help do not pay for them.
#include "host/model/levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tests/constraints/mixed_sheet.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
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
  scene.solver.levels = levels, scene.solver.levels_interval = every;
  return scene;
}
GridShape sheet_of(int side) { return {{2, 2}, {side - 1, side - 1}}; }

Measures after_a_second(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 1);
  return simulation.measure();
}

/// The bounds: plain sweeps gave 0.0075 and 0.036, levels 0.0011 and 0.0019.
TEST(Levels, StretchDoesNotGrowWithTheMesh) {
  EXPECT_LT(after_a_second(hung_sheet(sheet_of(46), kMaxLevels)).strain_rms, 0.003);
  const Measures fine = after_a_second(hung_sheet(sheet_of(100), kAutoLevels));
  EXPECT_LT(fine.strain_rms, 0.003);
  EXPECT_LT(fine.strain_max, 0.05);
  EXPECT_GT(after_a_second(hung_sheet(sheet_of(100), 0)).strain_rms, 0.03);
}

/// The sheet that sways to the other side has no more energy than at the start, which is 0 there.
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

/// The mean strain of its columns, of a sheet of 2 x 2 m that hangs at rest. The pinned row is at y = 0.
double hung_stretch(Shape shape, ConstraintSpec constraint, int substeps, int levels) {
  Scene scene = hung_sheet(shape, levels);
  BodySpec& body = scene.bodies[0];
  body.constraints = {std::move(constraint)};
  body.transform.axis = {1, 0, 0}, body.transform.degrees = 90;
  body.pins = {BoxPin{{-1, -1e-7, -1}, {3, 1, 1}}};
  body.damping = 0.2;
  scene.solver.substeps = substeps;
  Simulation simulation(scene, {.threads = 1});
  EXPECT_EQ(simulation.solver().facts().levels.empty(), levels == 0);
  const std::vector<Vec3> start = simulation.positions();
  run_for(simulation, scene, 3);
  const std::vector<Vec3> end = simulation.positions();
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < end.size(); ++i)
    if (start[i][1] < -1.999) sum += end[i][1] / start[i][1] - 1, ++count;
  return sum / count;
}

/// Springs of 300 N/m: 0.0050 by Newton's method on the springs at rest, at 33 and at 70 particles a side.
TEST(Levels, CompliantConstraintsHangAsLongAsAtEquilibrium) {
  const ConstraintSpec springs = compliant("distance", 1.0 / 300, {"edges", "shear"});
  EXPECT_NEAR(hung_stretch(sheet_of(33), springs, 10, kMaxLevels), 0.0050, 0.0005);
  EXPECT_NEAR(hung_stretch(sheet_of(70), springs, 10, kAutoLevels), 0.0050, 0.0005);
  EXPECT_GT(hung_stretch(sheet_of(70), springs, 10, 0), 0.015);
}

/// A strip of 0.25 kg/m^2 has a mean strain of g density L / (2 Y), of which its pinned row takes some percent.
TEST(Levels, MembranesHangAsLongAsAtEquilibriumOnAnyMesh) {
  const TemporaryFolder folder;
  ConstraintSpec membrane = stiff("membrane");
  membrane.young_modulus = 800, membrane.parameter = 0.3;
  const double expected = kG * 0.25 * 2 / (2 * 800);
  for (const unsigned seed : {3U, 4U}) {
    const MeshFile mesh{folder.write("sheet.obj", irregular_obj(2, 2, 66, 66, 0.25, seed))};
    EXPECT_NEAR(hung_stretch(mesh, membrane, 10, kAutoLevels), expected, 0.1 * expected);
    EXPECT_GT(hung_stretch(mesh, membrane, 10, 0), 3 * expected);
  }
}

/// The edges of a body's coarsening graph, and its bodies.
CoarseningGraph linkage_of_body(const BodySpec& body, const Vec3& gravity = kEarth) {
  const Model model = build_model(scene_of({body}, gravity, 1.0 / 60, 10));
  return coarsening_graph(model, model.w);
}

TEST(CoarseningGraph, OfAChainStretchesByTheWeightBelow) {
  BodySpec chain = hung_chain({0, 0, 0}, {0, -3, 0}, 3, 0.5);
  chain.constraints = {compliant("distance", 0.001, {"edges"})};
  const CoarseningGraph linkage = linkage_of_body(chain);
  // The forces in its three links of 1 m are the weights below them.
  const double m = 2.0 / 6, forces[] = {5 * m * kG, 3 * m * kG, m * kG};
  const double expected[] = {forces[0], (forces[0] + forces[1]) / 2, (forces[1] + forces[2]) / 2, forces[2] / 2};
  ASSERT_EQ(linkage.stretch.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(dot(linkage.stretch[i], linkage.stretch[i]), 0.001 * expected[i], 1e-9) << i;
    EXPECT_NEAR(std::abs(linkage.stretch[i].y), norm(linkage.stretch[i]), 1e-9) << i;
  }
}

TEST(CoarseningGraph, LeavesOutWhatIsMuchSofter) {
  BodySpec sheet;
  sheet.name = "sheet";
  sheet.shape = GridShape{{1, 1}, {8, 8}};
  sheet.mass = 1, sheet.pins = {RowPin{}};
  sheet.constraints = {compliant("distance", 1e-3, {"edges"}), compliant("distance", 0.1, {"shear"})};
  const std::size_t edges = 2 * 8 * 9 - 8, shear = 2 * 8 * 8;  // none between pins
  EXPECT_EQ(linkage_of_body(sheet).links.size(), edges);
  sheet.constraints[1].compliance = 2e-3;
  EXPECT_EQ(linkage_of_body(sheet).links.size(), edges + shear);
  sheet.constraints[0] = stiff("distance", {"edges"});
  EXPECT_EQ(linkage_of_body(sheet).links.size(), edges);
  EXPECT_TRUE(linkage_of_body(sheet).stretch.empty());
}

/// There are no levels for solids, for elastic bodies without pins or loads, and, unless they are named, for those that
/// weight stretches by more than 1 %.
TEST(Levels, AreNotForSolidsNorForWhatHasNoWeightNorForWhatIsSoft) {
  SolverSpec automatic, asked;
  automatic.levels = kAutoLevels, asked.levels = kMaxLevels;
  const GraphComponent stiff_part{.particles = 5000, .max_graph_distance = 70};
  EXPECT_TRUE(should_use_levels(stiff_part, automatic));
  GraphComponent solid = stiff_part, elastic = stiff_part;
  solid.solid = true;
  EXPECT_FALSE(should_use_levels(solid, asked));
  elastic.elastic = true, elastic.stretch = 0.005, elastic.compliance_loss = 50;
  EXPECT_TRUE(should_use_levels(elastic, automatic));
  elastic.stretch = 0.02;
  EXPECT_FALSE(should_use_levels(elastic, automatic));
  EXPECT_TRUE(should_use_levels(elastic, asked));
  elastic.stretch = 0.005, elastic.compliance_loss = 0.5;  // sweeps reach its compliance without levels
  EXPECT_FALSE(should_use_levels(elastic, automatic));
  elastic.compliance_loss = 50, elastic.loaded = true;  // a contact may stretch it too
  EXPECT_FALSE(should_use_levels(elastic, automatic));
  EXPECT_TRUE(should_use_levels(elastic, asked));
  elastic.stretch = 0;
  EXPECT_FALSE(should_use_levels(elastic, asked));
  GraphComponent soft = stiff_part;
  soft.soft = true;  // a stiffness below 1, with which levels are not used
  EXPECT_FALSE(should_use_levels(soft, automatic));

  BodySpec bar;
  bar.name = "bar", bar.mass = 1;
  const TemporaryFolder folder;
  bar.shape = MeshFile{folder.write("one.mesh",
                                    "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n"
                                    "0 0 1 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n")};
  bar.constraints = {stiff("distance", {"edges"})};
  EXPECT_TRUE(linkage_of_body(bar).parts[0].solid);
}

TEST(Levels, KeepTheMomentumOfAFreeBody) {
  BodySpec body = tumbling_ellipsoid(3, {stiff("distance", {"edges"})});
  for (const int levels : {0, kMaxLevels}) {
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

/// Curved at rest: no force acts, so that only the rounding of lengths moves it.
TEST(Levels, LeaveWhatIsAtRestAlone) {
  BodySpec ball, box;
  ball.shape = SphereShape{0.5, 4}, box.shape = BoxShape{{1, 1, 1}, {{140, 140, 140}}};
  for (BodySpec& body : {std::ref(ball), std::ref(box)}) {
    body.name = "body", body.mass = 1, body.constraints = {stiff("distance", {"edges"})};
    Scene scene = scene_of({body}, {}, 1.0 / 60, 10);
    scene.solver.levels = kMaxLevels;
    Simulation simulation(scene, {.threads = 1});
    // The box bends at its edges: one level has few enough of them.
    ASSERT_GE(simulation.solver().facts().levels.size(), &body == &ball ? 3U : 1U);
    const std::vector<Vec3> before = simulation.positions();
    run_for(simulation, scene, 0.2);
    const std::vector<Vec3> after = simulation.positions();
    for (std::size_t i = 0; i < after.size(); ++i) EXPECT_LT(length(after[i] - before[i]), 1e-9);
  }
}

/// An OBJ file of rows of quads: `at` is the position of a column and a row.
std::string grid_obj(int columns, int rows, const std::function<Vec3(int, int)>& at) {
  Mesh mesh;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) mesh.points.push_back(at(i, j));
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i) {
      const int a = j * columns + i;
      mesh.faces.push_back({a, a + columns, a + columns + 1, a + 1});
    }
  return obj_of(mesh);
}

/// A strip of 4 x 120 cells that is folded or waved at rest, hung by an end.
struct WavedStrip {
  const char* name;
  std::function<double(int)> slope;  // of the row's cell, rad
};

/// They unroll, whether the coarse constraints resolve their folds or not.
TEST(Levels, LetWhatIsFoldedAtRestUnroll) {
  const int columns = 5, rows = 121;
  const double cell = 2.0 / (rows - 1);
  const WavedStrip strips[] = {
      {"zigzag", [](int j) { return j / 4 % 2 == 0 ? 1.0 : -1.0; }},
      {"layers", [](int j) { return j / 30 % 2 == 0 ? 0.0 : 3.05; }},
      {"sharp", [](int j) { return j % 2 == 0 ? 1.2 : -1.2; }},
      {"wave", [](int j) { return 1.0 * std::sin(2 * kPi * j / 12); }},
      {"long wave", [](int j) { return 1.0 * std::sin(2 * kPi * j / 60); }},
  };
  for (const WavedStrip& strip : strips)
    for (const int levels : {kAutoLevels, kMaxLevels}) {
      const TemporaryFolder folder;
      std::vector<Vec3> row{{0, 0, 0}};
      for (int j = 0; j + 1 < rows; ++j)
        row.push_back({0, row[j][1] - cell * std::cos(strip.slope(j)), row[j][2] + cell * std::sin(strip.slope(j))});
      const std::string obj = grid_obj(columns, rows, [&](int i, int j) {
        return Vec3{cell * i, row[j][1], row[j][2]};
      });
      BodySpec body;
      body.name = "strip", body.mass = 0.1, body.damping = 0.1;
      body.shape = MeshFile{folder.write("strip.obj", obj)};
      body.constraints = {stiff("distance", {"edges", "shear"})};
      body.pins = {ListPin{{0, 1, 2, 3, 4}}};
      Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10);
      scene.solver.levels = levels;
      Simulation simulation(scene, {.threads = 1});
      run_for(simulation, scene, 3);
      double lowest = 0;
      for (const Vec3& x : simulation.positions()) lowest = std::min(lowest, x[1]);
      // The length is shorter by the fold that is one cell thick, and longer by the stretch that sweeps leave of its
      // weight.
      EXPECT_LT(lowest, -1.9) << strip.name << ", levels " << levels;
      EXPECT_GT(lowest, -2.2) << strip.name << ", levels " << levels;
    }
}

/// Nets have no resistance to shear: coarse constraints run along their rows and columns, and only there.
TEST(Levels, OfANetLeaveItsShearFree) {
  BodySpec net;
  net.name = "net", net.mass = 1, net.shape = GridShape{{2, 2}, {64, 64}};
  net.pins = {RowPin{}}, net.constraints = {stiff("distance", {"edges"})};
  Scene scene = scene_of({net}, kEarth, 1.0 / 60, 10);
  scene.solver.levels = 3;
  const Model model = build_model(scene);
  const std::vector<Level> levels = make_levels(model, model.w);
  ASSERT_EQ(levels.size(), 3U);
  for (int l = 0, side = 33; l < 3; ++l, side = side / 2 + 1) {
    const Model& level = levels[l].model;
    EXPECT_EQ(level.count(), side * side) << "every second row and column";
    for (const ConstraintSet& set : level.sets)
      for (int c = 0; c < set.count(); ++c) {
        const Vec3 &a = level.x[set.particles[2 * c]], &b = level.x[set.particles[2 * c + 1]];
        const double along = std::max(std::abs(a[0] - b[0]), std::abs(a[2] - b[2]));
        const double across = std::min(std::abs(a[0] - b[0]), std::abs(a[2] - b[2]));
        EXPECT_LT(across, 0.7 * along) << "level " << l;  // 1 along diagonals; at rims mass centres lie inside
      }
  }
}

/// A sheet that is bent to a half pipe at rest, unrolled: no coarse constraint may be shorter than the unrolled
/// distance, nor much longer. `place`: position in the unrolled sheet.
TEST(Levels, AreAsLongAsTheSheetIsUnrolled) {
  const int side = 49;
  const double radius = 2 / kPi;
  const TemporaryFolder folder;
  const std::string obj = grid_obj(side, side, [&](int i, int j) {
    const double angle = kPi * i / (side - 1);
    return Vec3{radius * std::cos(angle), radius * std::sin(angle), 2.0 * j / (side - 1)};
  });
  Scene scene = hung_sheet(MeshFile{folder.write("pipe.obj", obj)}, kMaxLevels);
  scene.bodies[0].constraints = {stiff("distance", {"edges", "shear"})};
  const Model model = build_model(scene);
  const std::vector<Level> levels = make_levels(model, model.w);
  ASSERT_GE(levels.size(), 4U);
  std::vector<Vec3> flat;  // of the finer particles, in their order
  for (const int user : model.user_index)
    flat.push_back({2.0 * (user % side) / (side - 1), 0, 2.0 * (user / side) / (side - 1)});
  for (std::size_t l = 0; l < 4; ++l) {
    const Level& level = levels[l];
    std::vector<Vec3> coarse(level.model.x.size());
    for (int rank = 0; rank < level.restriction.count(); ++rank) {
      Vec3 mean{};
      for (int k = level.restriction.begin[rank]; k < level.restriction.begin[rank + 1]; ++k)
        for (int d = 0; d < 3; ++d) mean[d] += level.restriction.weight[k] * flat[level.restriction.of[k]][d];
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

/// After its pins are released a sheet falls freely: its levels no longer hang from anything.
TEST(Levels, FallWhenTheirPinsRelease) {
  Scene scene = hung_sheet(sheet_of(70), kAutoLevels, 2, Precision::Double);
  scene.bodies[0].pins[0].release_time = 0.2;
  Simulation simulation(scene, {.threads = 1});
  ASSERT_FALSE(simulation.solver().facts().levels.empty());
  run_for(simulation, scene, 0.25);
  const double before = simulation.measure().momentum[1];
  run_for(simulation, scene, 0.25);
  EXPECT_NEAR(simulation.measure().momentum[1], before - 1 * kG * 0.25, 1e-9);  // 1 kg; rounding
}

/// The distance from the same sheet after 120 substeps of plain sweeps: 0.08 m with levels, 0.25 without.
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

/// Bodies whose particles are fewer than 12 edges from their pins, those with more sweeps than edges, and those without
/// pins.
TEST(Levels, AreNotThereWhereTheyHelpNobody) {
  const auto hung = [](int edges, int substeps, int iterations) {
    Scene scene = hung_sheet(sheet_of(edges + 1), kAutoLevels);
    scene.solver.substeps = substeps, scene.solver.iterations = iterations;
    return scene;
  };
  for (const Scene& scene : {hung(12, 10, 1), hung(12, 6, 2), hung(40, 40, 1), hung(40, 20, 2)})
    EXPECT_FALSE(Simulation(scene, {.threads = 1}).solver().facts().levels.empty());
  Scene small = hung(11, 10, 1), often = hung(40, 41, 1), again = hung(40, 7, 6), loose = hung(69, 10, 1);
  loose.bodies[0].pins.clear();
  for (Scene* scene : {&small, &often, &again, &loose}) {
    Simulation automatic(*scene, {.threads = 1});
    scene->solver.levels = 0;
    Simulation off(*scene, {.threads = 1});
    EXPECT_TRUE(automatic.solver().facts().levels.empty());
    EXPECT_EQ(automatic.solver().facts().level_bytes, 0U);
    for (int step = 0; step < 3; ++step) automatic.step(), off.step();
    EXPECT_EQ(automatic.state_hash(), off.state_hash());
  }
}

/// Each particle's prolongation weights reproduce its position in the flat sheet, except at the boundary, with at most
/// 4 parents.
TEST(Levels, ParticlesFollowThoseAroundThem) {
  const TemporaryFolder folder;
  const Scene scene = hung_sheet(MeshFile{folder.write("sheet.obj", irregular_obj(2, 2, 40, 40, 0.25, 5))}, 1);
  const Model model = build_model(scene);
  const Level level = make_levels(model, model.w).front();
  double squares = 0;
  for (int i = 0; i < level.prolongation.count(); ++i) {
    if (model.w[i] == 0) {
      EXPECT_EQ(level.prolongation.begin[i], level.prolongation.begin[i + 1]);  // pins have no parents
      continue;
    }
    Vec3 mean{};
    double sum = 0;
    for (int k = level.prolongation.begin[i]; k < level.prolongation.begin[i + 1]; ++k) {
      const Vec3& at = level.model.x[level.particle[level.prolongation.of[k]]];
      sum += level.prolongation.weight[k];
      for (int d = 0; d < 3; ++d) mean[d] += level.prolongation.weight[k] * at[d];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_LE(level.prolongation.begin[i + 1] - level.prolongation.begin[i], 4);
    const double off = length(mean - model.x[i]);
    squares += off * off / level.prolongation.count();
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
  EXPECT_EQ(with("").levels_interval, 0);
  EXPECT_EQ(with(R"(, "levels": "off")").levels, 0);
  EXPECT_EQ(with(R"(, "levels": 3, "levels_interval": 1)").levels, 3);
  EXPECT_NE(refusal([&] { with(R"(, "levels": "many")"); }).find("/solver/levels: found"), std::string::npos);
  EXPECT_NE(refusal([&] { with(R"(, "levels": 0)"); }).find("/solver/levels: found"), std::string::npos);
  for (const char* every : {R"(, "levels_interval": 0)", R"(, "levels_interval": 4)"})
    EXPECT_NE(refusal([&] { with(every); }).find("/solver/levels_interval: found"), std::string::npos);
}

TEST(Levels, ActInEachSubstepOfWhatIsDriven) {
  const auto every = [](const std::function<void(Scene&)>& change) {
    Scene scene = hung_sheet(sheet_of(20), kAutoLevels, 0);
    change(scene);
    return levels_interval(build_model(scene));
  };
  EXPECT_EQ(every([](Scene&) {}), 2);
  EXPECT_EQ(every([](Scene& scene) { scene.wind = Wind{{1, 0, 0}, 1.2}; }), 1);
  EXPECT_EQ(every([](Scene& scene) { scene.bodies[0].pins[0].release_time = 0.5; }), 2);
  EXPECT_EQ(every([](Scene& scene) { scene.bodies[0].pins[0].motion = {{0.1}, {0.2, {1, 0, 0}}}; }), 1);
  EXPECT_EQ(every([](Scene& scene) { scene.wind = Wind{{1, 0, 0}, 1.2}, scene.solver.levels_interval = 3; }), 3);
  EXPECT_EQ(every([](Scene& scene) {
              scene.environment.emplace_back();
              scene.environment[0].name = "pole", scene.environment[0].shape = GridShape{{3, 3}, {1, 1}};
              scene.environment[0].sides = Sides::TwoSided;
              scene.environment[0].transform.translate = {0, -9, 0};
              scene.environment[0].motion = {{0.1}, {0.2, {1, 0, 0}}};
              Attachment to;
              to.at = BoxPin{{-1, -1, -1e-9}, {3, 1, 1e-9}}, to.environment = "pole";
              scene.bodies[0].pins.clear(), scene.bodies[0].attachments = {to};
            }),
            1);
}

Scene sheet_over_a_ball() {
  Scene scene = hung_sheet(sheet_of(70), kAutoLevels);
  EnvironmentSpec ball;
  ball.name = "ball", ball.shape = SphereShape{0.4, 3}, ball.transform.translate = {1, -0.5, 1.2};
  scene.environment = {ball};
  return scene;
}

INSTANTIATE_TEST_SUITE_P(
    Levels, SameBits,
    testing::Values(SameBitsScene{"Hung", [](const auto&) { return hung_sheet(sheet_of(70), kAutoLevels); }, 8, {3}},
                    SameBitsScene{"OverABall", [](const auto&) { return sheet_over_a_ball(); }, 8, {3}}),
    name_of_scene);

}  // namespace
}  // namespace malha
