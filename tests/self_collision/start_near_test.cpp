// SPDX-License-Identifier: Apache-2.0
// Pairs that start nearer than the thickness keep their distance until they separate by themselves: they gain no speed
// from it, at any number of substeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/mesh/irregular_sheet.h"
#include "tests/same_bits.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kThickness = 0.01, kNearer = 0.001;  // m

enum class Cells { Squares, Irregular };

/// Half a metre square, 0.1 kg, 5 cm cells, in the plane y = height.
BodySpec near_sheet(const std::string& name, double height, Cells cells, const TemporaryFolder& folder) {
  BodySpec body;
  body.name = name;
  Random random(name == "a" ? 3 : 4);
  if (cells == Cells::Squares)
    body.shape = GridShape{{0.5, 0.5}, {10, 10}};
  else
    body.shape = MeshFile{folder.write(name + ".obj", irregular_sheet(0.5, 0.5, 10, 9, random))};
  body.transform.translate = {0, height, 0};
  body.mass = 0.1;
  body.constraints = {stiff("distance", {"edges"})};
  return body;
}

/// Pins all but one particle, which hangs on the others, because a body needs a movable one.
Pin all_but_first(int particles) {
  ListPin all;
  for (int i = 1; i < particles; ++i) all.particles.push_back(i);
  return all;
}

Scene near_scene(std::vector<BodySpec> bodies, int substeps, const std::string& method, Precision precision,
                 const Vec3& gravity = {}) {
  Scene scene = scene_of(std::move(bodies), gravity, 1.0 / 60, substeps, precision);
  scene.self_collision = SelfCollision{kThickness, 0.3, {}};
  scene.solver.type = method;
  return scene;
}

/// The largest speed after any of that many steps, of the particles from `first` on.
double fastest_of(Simulation& simulation, int steps, std::size_t first = 0) {
  double fastest = 0;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    const std::vector<Vec3> v = simulation.velocities();
    for (std::size_t i = first; i < v.size(); ++i) fastest = std::max(fastest, length(v[i]));
  }
  return fastest;
}

/// The speed due to rounding (m/s): four times that without contacts, and ten ulps of half a metre in a substep.
double rounding(Scene scene, int steps) {
  const double ulp = scene.solver.precision == Precision::Float ? 6e-8 : 1.1e-16;
  const double of_places = 10 * 0.5 * ulp * scene.solver.substeps / scene.solver.dt;
  scene.self_collision.reset(), scene.environment.clear();
  Simulation alone(scene, {.threads = 1});
  return of_places + 4 * fastest_of(alone, steps);
}

/// Calls a function for every method, precision and these numbers of substeps.
template <class Check>
void in_every_way(const std::vector<int>& substeps, const Check& check) {
  for (const std::string method : {"pbd", "desbrun"})
    for (const Precision precision : {Precision::Float, Precision::Double})
      for (const int many : substeps) {
        SCOPED_TRACE(method + (precision == Precision::Float ? ", float, " : ", double, ") + std::to_string(many) +
                     " substeps");
        check(method, precision, many);
      }
}

TEST(StartsNear, TwoSheetsStayAtRest) {
  const TemporaryFolder folder;
  for (const Cells cells : {Cells::Squares, Cells::Irregular})
    in_every_way({1, 10, 40, 160}, [&](const std::string& method, Precision precision, int substeps) {
      const Scene scene = near_scene({near_sheet("a", 0, cells, folder), near_sheet("b", kNearer, cells, folder)},
                                     substeps, method, precision);
      Simulation simulation(scene, {.threads = 1});
      EXPECT_LT(fastest_of(simulation, 3), rounding(scene, 3));
    });
}

// Where the sheets are bent, some particles lie nearer than the rest: pushing those alone would stretch both.
TEST(StartsNear, SheetsOfWhichSomeIsNearStayAtRest) {
  const TemporaryFolder folder;
  in_every_way({1, 10, 160}, [&](const std::string& method, Precision precision, int substeps) {
    BodySpec upper = near_sheet("b", kNearer, Cells::Irregular, folder);
    upper.transform.axis = {0, 0, 1}, upper.transform.degrees = 5;
    upper.transform.translate = {0.1, kNearer, 0.05};
    const Scene scene = near_scene({near_sheet("a", 0, Cells::Irregular, folder), upper}, substeps, method, precision);
    Simulation simulation(scene, {.threads = 1});
    EXPECT_LT(fastest_of(simulation, 3), rounding(scene, 3));
  });
}

TEST(StartsNear, SheetsThatArePlacedThereStayAtRest) {
  const TemporaryFolder folder;
  for (const int substeps : {10, 160}) {
    const Scene scene =
        near_scene({near_sheet("a", 0, Cells::Irregular, folder), near_sheet("b", 0.1, Cells::Irregular, folder)},
                   substeps, "pbd", Precision::Double);
    Simulation simulation(scene, {.threads = 1});
    simulation.step();
    std::vector<Vec3> x = simulation.positions();
    for (Vec3& at : x) at[1] = at[1] > 0.05 ? kNearer : 0;
    simulation.set_positions(x);
    EXPECT_LT(fastest_of(simulation, 3), rounding(scene, 3)) << substeps;
    // Setting velocities alone is no new start: pairs that were near stay so.
    simulation.set_velocities(std::vector<Vec3>(x.size()));
    EXPECT_LT(fastest_of(simulation, 3), rounding(scene, 3)) << substeps;
  }
}

// Pins press one sheet to a millimetre from the other, pinned too, and release both there.
TEST(StartsNear, WhatPinsPressedTogetherStaysAtRestWhereTheyRelease) {
  const TemporaryFolder folder;
  for (const int substeps : {10, 160}) {
    BodySpec lower = near_sheet("a", 0, Cells::Squares, folder), upper = near_sheet("b", 0.03, Cells::Squares, folder);
    Pin held{BoxPin{{-1, -1, -1}, {1, 1, 1}}};
    held.release_time = 0.1;
    Pin driven = held;
    Keyframe start, end;
    end.time = 0.05, end.translate = {0, kNearer - 0.03, 0};
    driven.motion = {start, end};
    lower.pins = {held}, upper.pins = {driven};
    const Scene scene = near_scene({lower, upper}, substeps, "pbd", Precision::Double);
    Simulation simulation(scene, {.threads = 1});
    run_for(simulation, scene, 0.1);
    EXPECT_LT(fastest_of(simulation, 5), 1e-9) << substeps;
    EXPECT_NEAR(simulation.positions().back()[1], kNearer, 1e-9);
  }
}

// A body that intersects another at the start is moved out of it at 0.1 m/s: after separation they are near.
TEST(StartsNear, WhatCrossedIsNotShotApartOnceItHasParted) {
  const TemporaryFolder folder;
  for (const int substeps : {10, 160}) {
    BodySpec upright = near_sheet("b", 0, Cells::Irregular, folder);
    upright.transform.axis = {1, 0, 0}, upright.transform.degrees = 90;
    upright.transform.translate = {0.013, 0.015, 0.2};
    Pin held = all_but_first(11 * 10);
    Keyframe start, end;
    end.time = 1, end.translate = {0, -0.1, 0};
    held.motion = {start, end};
    upright.pins = {held};
    Scene scene =
        near_scene({near_sheet("a", 0, Cells::Irregular, folder), upright}, substeps, "pbd", Precision::Double);
    scene.self_collision->ignores_crossings = true;
    Simulation simulation(scene, {.threads = 1});
    ASSERT_GT(simulation.measure().crossings, 5);
    EXPECT_LT(fastest_of(simulation, 20), 0.12) << substeps;
    EXPECT_EQ(simulation.measure().crossings, 0) << substeps;
  }
}

// Pairs of edges, and of particles and triangles, each without the other kind.
TEST(StartsNear, LinesAndLooseParticlesStayAtRest) {
  const TemporaryFolder folder;
  for (const int substeps : {1, 10, 160}) {
    BodySpec one = body("one", ChainShape{{0, 0, 0}, {0.5, 0, 0}, 10}, {stiff("distance", {"edges"})});
    BodySpec other =
        body("other", ChainShape{{0.22, kNearer, -0.2}, {0.23, kNearer, 0.3}, 9}, {stiff("distance", {"edges"})});
    const BodySpec cloud = body("lattice", LatticeShape{{0.1, kNearer, 0.1}, {0.4, 2 * kNearer, 0.4}, {4, 2, 4}});
    for (const auto& bodies : {std::vector{one, other}, {near_sheet("a", 0, Cells::Irregular, folder), cloud}}) {
      const Scene scene = near_scene(bodies, substeps, "pbd", Precision::Double);
      Simulation simulation(scene, {.threads = 1});
      EXPECT_LT(fastest_of(simulation, 3), rounding(scene, 3)) << substeps << " substeps";
    }
  }
}

// Pins press particles onto others, and one side goes away at once: the deficit, at most the thickness, is corrected in
// 16 ms, so that they move at 0.625 m/s at most. With a tenth a substep it was 5.9 m/s with 160 substeps.
TEST(StartsNear, WhatIsPressedNearerComesBackAsFastAtAnyNumberOfSubsteps) {
  const TemporaryFolder folder;
  for (const int substeps : {10, 40, 160}) {
    BodySpec lower = near_sheet("a", 0, Cells::Squares, folder), upper = near_sheet("b", 0.03, Cells::Squares, folder);
    lower.pins = {all_but_first(11 * 11)};
    Pin driven = all_but_first(11 * 11);
    Keyframe start, pressed, away;
    pressed.time = 0.1, pressed.translate = {0, kThickness - 0.03, 0};
    away.time = 0.12, away.translate = {0, 0.1, 0};
    driven.motion = {start, pressed, away};
    upper.pins = {driven};
    const BodySpec cloud = body("lattice", LatticeShape{{0.2, 0.015, 0.2}, {0.3, 0.015, 0.3}, {3, 1, 3}});
    const Scene scene = near_scene({lower, upper, cloud}, substeps, "pbd", Precision::Double);
    Simulation simulation(scene, {.threads = 1});
    run_for(simulation, scene, 0.1);
    EXPECT_LT(simulation.positions().back()[1], 0.7 * kThickness) << substeps;
    EXPECT_LT(fastest_of(simulation, 3, 2 * 11 * 11), kThickness / 0.016) << substeps;
  }
}

// A load neither presses it nearer nor, once the pair has separated, keeps it nearer than the thickness.
TEST(StartsNear, KeepsItsDistanceUnderAWeightAndTheThicknessOnceItHasOpened) {
  const TemporaryFolder folder;
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    BodySpec lower = near_sheet("a", 0, Cells::Squares, folder);
    lower.shape = GridShape{{0.7, 0.7}, {14, 14}}, lower.transform.translate = {-0.1, 0, -0.1};
    lower.pins = {all_but_first(15 * 15)};
    const BodySpec upper = near_sheet("b", kNearer, Cells::Irregular, folder);
    Simulation simulation(near_scene({lower, upper}, 20, "pbd", precision, kEarth), {.threads = 1});
    const std::size_t first = 15 * 15;  // the particles of the upper one
    const auto lowest = [&] {
      const std::vector<Vec3> x = simulation.positions();
      double low = INFINITY;
      for (std::size_t i = first; i < x.size(); ++i) low = std::min(low, x[i][1]);
      return low;
    };
    EXPECT_LT(fastest_of(simulation, 60, first), 0.01);
    EXPECT_NEAR(lowest(), kNearer, 0.05 * kThickness);
    std::vector<Vec3> v(simulation.positions().size());
    for (std::size_t i = first; i < v.size(); ++i) v[i] = {0, 0.8, 0};
    simulation.set_velocities(v);  // it is thrown up by 3 cm, and falls again
    fastest_of(simulation, 60);
    EXPECT_NEAR(lowest(), kThickness, 0.05 * kThickness);
  }
}

// A sheet above a solid that is smaller: particles over it are near, those beside it are not.
TEST(StartsNear, ASheetOverASolidStaysAtRest) {
  const TemporaryFolder folder;
  EnvironmentSpec box = obstacle("box", BoxShape{{0.23, 0.2, 0.17}, {{1, 1, 1}}});
  box.transform.translate = {0.25, -0.1 - kNearer, 0.25};
  EnvironmentSpec ball = obstacle("ball", SphereShape{0.3, 3});
  ball.transform.translate = {0.25, -0.3 - kNearer, 0.25};
  for (EnvironmentSpec solid : {box, ball})
    for (const bool edges : {false, true})
      in_every_way({1, 10, 160}, [&](const std::string& method, Precision precision, int substeps) {
        Scene scene = near_scene({near_sheet("a", 0, Cells::Irregular, folder)}, substeps, method, precision);
        solid.thickness = kThickness, solid.edges = edges;
        scene.self_collision.reset();
        scene.environment = {solid};
        Simulation simulation(scene, {.threads = 1});
        EXPECT_LT(fastest_of(simulation, 3), rounding(scene, 3)) << solid.name << (edges ? ", edges" : "");
      });
}

/// A box whose top is at y = 0, so that a body at height y lies y above it; its thickness is 5 mm, and it is narrower
/// than the bodies on it.
EnvironmentSpec sunk_in(Sides sides) {
  EnvironmentSpec solid = obstacle("box", BoxShape{{0.33, 0.2, 0.37}, {{1, 1, 1}}});
  solid.transform.translate = {0.25, -0.1, 0.25};
  if (sides != Sides::Solid)
    solid = obstacle("floor", GridShape{{0.33, 0.37}, {1, 1}}, sides), solid.transform.translate = {0.085, 0, 0.065};
  solid.thickness = 0.005;
  return solid;
}

// The part of a body that is inside stays as deep as it is: moved out, it would stretch the rest, and a block of
// tetrahedra got 14 m/s by that with 160 substeps, a ball 10 m/s though it only touched.
TEST(StartsNear, WhatLiesInASolidByLessThanItsThicknessStaysAtRest) {
  const TemporaryFolder folder;
  for (const Sides sides : {Sides::Solid, Sides::OneSided, Sides::TwoSided})
    for (const double depth : {0.0, 0.0049}) {
      BodySpec sheet = near_sheet("a", -depth, Cells::Irregular, folder);
      sheet.transform.axis = {1, 0, 0}, sheet.transform.degrees = 0.3;  // by 2.6 mm from one rim to the other
      BodySpec block = body("block", TetBoxShape{{0.4, 0.1, 0.4}, {4, 2, 4}}, {stiff("distance", {"edges"})});
      block.transform.translate = {0.25, 0.05 - depth, 0.25};
      BodySpec ball = body("ball", SphereShape{0.1, 2}, {stiff("distance", {"edges"}), stiff("bending")});
      ball.transform.translate = {0.25, 0.1 - depth, 0.25};
      if (depth == 0.0049) sheet.transform.translate[1] += 0.0026;
      for (const BodySpec& one : {sheet, block, ball})
        for (const bool collides : {false, true})
          in_every_way({1, 10, 160}, [&](const std::string& method, Precision precision, int substeps) {
            Scene scene = near_scene({one}, substeps, method, precision);
            if (!collides) scene.self_collision.reset();
            scene.environment = {sunk_in(sides)};
            Simulation simulation(scene, {.threads = 1});
            EXPECT_LT(fastest_of(simulation, 2), rounding(scene, 2))
                << one.name << ", depth " << depth << (collides ? ", self-collision" : "");
          });
    }
}

// Its weight does not press it deeper, and once it has come out it stays out.
TEST(StartsNear, WhatLiesInASolidGoesNoDeeperAndStaysOutOnceItWasOut) {
  const TemporaryFolder folder;
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const double depth = 0.003, thickness = 0.005;
    const BodySpec sheet = near_sheet("a", -depth, Cells::Irregular, folder);
    Scene scene = near_scene({sheet}, 20, "pbd", precision, kEarth);
    scene.environment = {obstacle("box", BoxShape{{2, 0.2, 2}, {{1, 1, 1}}})};
    scene.environment[0].transform.translate = {0, -0.1, 0}, scene.environment[0].thickness = thickness;
    Simulation simulation(scene, {.threads = 1});
    EXPECT_LT(fastest_of(simulation, 60), 0.01);
    EXPECT_NEAR(simulation.measure().penetration_max, depth, 0.02 * thickness);
    simulation.set_velocities(std::vector<Vec3>(simulation.positions().size(), {0, 0.8, 0}));
    fastest_of(simulation, 60);
    EXPECT_EQ(simulation.measure().penetration_max, 0);
    for (const Vec3& x : simulation.positions()) EXPECT_GT(x[1], 0.95 * thickness);
  }
}

// A pin carries a particle into a solid, by less than the thickness, and releases it there.
TEST(StartsNear, WhatPinsOrHandlesReleaseInASolidStaysAtRest) {
  const TemporaryFolder folder;
  for (const int substeps : {10, 160})
    for (const bool interactive : {false, true}) {
      BodySpec sheet = near_sheet("a", 0.02, Cells::Irregular, folder);
      Pin held{BoxPin{{-1, -1, -1}, {1, 1, 1}}};
      held.release_time = 0.1;
      Keyframe start, end;
      end.time = 0.05, end.translate = {0, -0.023, 0};
      held.motion = {start, end};
      if (!interactive) sheet.pins = {held};
      Scene scene = near_scene({sheet}, substeps, "pbd", Precision::Double);
      scene.environment = {sunk_in(Sides::Solid)};
      Simulation simulation(scene, {.threads = 1, .interactive = true});
      if (interactive) {
        const std::vector<Vec3> x = simulation.positions();
        for (int i = 0; i < static_cast<int>(x.size()); ++i) simulation.hold(i, {x[i][0], -0.003, x[i][2]});
        for (int step = 0; step < 3; ++step) simulation.step();
        for (int i = 0; i < static_cast<int>(x.size()); ++i) simulation.release(i);
        simulation.set_velocities(std::vector<Vec3>(x.size()));
      } else {
        run_for(simulation, scene, 0.1);
      }
      EXPECT_LT(fastest_of(simulation, 5), 1e-9) << substeps << (interactive ? ", by hand" : "");
      EXPECT_NEAR(simulation.positions().back()[1], -0.003, 1e-9);
    }
}

// Attachments press a loose sheet between two others, nearer than the thickness at some points, and end there: the
// pressed pairs do not throw it out. It jams, and so is never at rest.
TEST(StartsNear, WhatAttachmentsPressedTogetherGetsNoFasterWhereTheyEnd) {
  const TemporaryFolder folder;
  for (const int substeps : {10, 40}) {
    std::vector<BodySpec> sheets;
    for (int k = 0; k < 3; ++k) {
      Random random(k + 5);
      BodySpec sheet = near_sheet(std::string(1, static_cast<char>('a' + k)), 0.03 * k, Cells::Irregular, folder);
      sheet.shape = MeshFile{folder.write(sheet.name + ".obj", irregular_sheet(0.5, 0.5, 10, 9, random))};
      Attachment tied;
      tied.at = BoxPin{{-1, -1, -1}, {1, 1, 1}}, tied.compliance = 0.01, tied.release_time = 0.4;
      Keyframe start, end;
      end.time = 0.05, end.translate = {0, -0.0285 * k, 0};
      tied.motion = {start, end};
      if (k != 1) sheet.attachments = {tied};
      sheets.push_back(sheet);
    }
    Simulation simulation(near_scene(sheets, substeps, "pbd", Precision::Double), {.threads = 1});
    for (int step = 0; step < 24; ++step) simulation.step();
    const double before = simulation.measure().speed_max;
    EXPECT_LT(fastest_of(simulation, 6), 1.2 * before) << substeps << ": a jam is never at rest";
  }
}

// A block on the ground: its lowest layer alone is near.
TEST(StartsNear, ABlockThatTouchesTheGroundIsNotThrownUp) {
  for (const int substeps : {10, 160}) {
    BodySpec block = body("block", TetBoxShape{{0.3, 0.1, 0.1}, {6, 2, 2}}, {neo_hookean(1e6, 0.3)});
    EnvironmentSpec ground = obstacle("ground", GridShape{{2, 2}, {2, 2}}, Sides::OneSided);
    ground.transform.translate = {-1, -0.05, -1};
    ground.thickness = kThickness;
    Scene scene = scene_of({block}, kEarth, 1.0 / 60, substeps);
    scene.environment = {ground};
    Simulation simulation(scene, {.threads = 1});
    // It is moved out by a fiftieth of the thickness; when it was all of it, that gave 1.5 m/s with 10 substeps.
    EXPECT_LT(fastest_of(simulation, 10), 0.2) << substeps;
  }
}

INSTANTIATE_TEST_SUITE_P(StartsNear, SameBits,
                         testing::Values(SameBitsScene{
                             "AboveABox",
                             [](const TemporaryFolder& folder) {
                               BodySpec upper = near_sheet("b", kNearer, Cells::Irregular, folder);
                               upper.transform.axis = {0, 0, 1}, upper.transform.degrees = 5;
                               upper.spin = {0.5, 0.2, 1};
                               Scene scene = near_scene({near_sheet("a", 0, Cells::Irregular, folder), upper}, 10,
                                                        "pbd", Precision::Float, kEarth);
                               EnvironmentSpec box = obstacle("box", BoxShape{{0.2, 0.2, 0.2}, {{1, 1, 1}}});
                               box.transform.translate = {0.25, -0.1 - kNearer, 0.25};
                               box.edges = true;
                               scene.environment = {box};
                               return scene;
                             },
                             10,
                             {5}}),
                         name_of_scene);

}  // namespace
}  // namespace malha
