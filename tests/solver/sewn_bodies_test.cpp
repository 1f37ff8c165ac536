// SPDX-License-Identifier: Apache-2.0
// Sewn bodies move as one: against whole bodies, closed forms and conserved quantities.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "host/mesh/generate.h"
#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

SeamSpec sewn_rows(const std::string& from, Selector at, const std::string& to, Selector there, double within,
                   double closing = 0) {
  SeamSpec seam;
  seam.from = {from, std::move(at)}, seam.to = {to, std::move(there)}, seam.within = within, seam.closing = closing;
  return seam;
}

/// A cloth of 1 m and 0.2 kg that hangs down, n x n cells, whole or of two halves that are sewn in the middle.
Scene sewn_cloth(int n, bool halves, std::vector<ConstraintSpec> constraints) {
  const auto part = [&](const std::string& name, double from, double to) {
    BodySpec cloth =
        body(name, GridShape{{1, to - from}, {n, static_cast<int>(std::lround(n * (to - from)))}}, constraints);
    cloth.transform.axis = {1, 0, 0}, cloth.transform.degrees = 90, cloth.transform.translate = {0, -from, 0};
    cloth.mass.reset(), cloth.density = 0.2, cloth.damping = 0.02;
    return cloth;
  };
  Scene scene = halves ? scene_of({part("upper", 0, 0.5), part("lower", 0.5, 1)}) : scene_of({part("whole", 0, 1)});
  scene.bodies[0].pins = {RowPin{}};
  scene.gravity = kEarth, scene.solver.dt = 1.0 / 60, scene.solver.substeps = 10;
  if (halves) scene.seams = {sewn_rows("upper", RowPin{true}, "lower", RowPin{}, 1e-6)};
  return scene;
}

struct HungSewn {
  double lowest = 0, mean = 0;  // m
  Measures measures;
};
HungSewn hang_sewn(const Scene& scene, double seconds) {
  const Simulation simulation = after(scene, seconds);
  HungSewn hung;
  const std::vector<Vec3> x = simulation.positions();
  for (const Vec3& at : x)
    hung.lowest = std::min(hung.lowest, at[1]), hung.mean += at[1] / static_cast<double>(x.size());
  hung.measures = simulation.measure();
  return hung;
}

TEST(SewnBodies, HangAsTheWholeClothDoes) {
  for (const bool elastic : {false, true}) {
    ConstraintSpec stretch = constraint(elastic ? "membrane" : "distance", elastic ? 0.3 : 1);
    if (elastic)
      stretch.young_modulus = 100;
    else
      stretch.elements = {"edges", "shear"};
    const HungSewn whole = hang_sewn(sewn_cloth(16, false, {stretch}), 4),
                   halves = hang_sewn(sewn_cloth(16, true, {stretch}), 4);
    // The halves have a row more, each with half of the mass of a whole one.
    EXPECT_NEAR(halves.lowest, whole.lowest, 1e-3) << elastic;
    EXPECT_NEAR(halves.mean, whole.mean, 1e-3 + 0.5 / 34) << elastic << ", whose sewn row counts twice";
    EXPECT_LT(halves.measures.max_seam_gap, 1e-5) << elastic << ", of cells of 62 mm";
    if (!elastic) {
      // The sewn rows of half the mass are one link more in the chain of a sweep: 2.7e-4, where the whole has 1.3e-4.
      EXPECT_LT(halves.measures.strain_rms, 3 * whole.measures.strain_rms);
    } else {
      EXPECT_GT(-whole.lowest, 1.005) << "it stretches";
    }
  }
}

TEST(SewnBodies, AreOneBodyToLevels) {
  ConstraintSpec stretch = constraint("distance");
  stretch.elements = {"edges", "shear"};
  const Scene scene = sewn_cloth(64, true, {stretch});
  Scene alone = scene;
  alone.solver.levels = 0;
  const HungSewn whole = hang_sewn(sewn_cloth(64, false, {stretch}), 1), halves = hang_sewn(scene, 1),
                 by_sweeps = hang_sewn(alone, 1);
  ASSERT_TRUE(Simulation(scene, {.threads = 1}).solver().has_levels());
  EXPECT_NEAR(halves.lowest, whole.lowest, 0.01);
  EXPECT_LT(halves.measures.strain_rms, 1.5 * whole.measures.strain_rms);
  EXPECT_GT(by_sweeps.measures.strain_rms, 3 * halves.measures.strain_rms) << "what levels are for";
  EXPECT_LT(halves.measures.max_seam_gap, 1e-3);
}

TEST(SewnBodies, KeepTheirMomenta) {
  ConstraintSpec stretch = constraint("distance");
  BodySpec one = body("one", GridShape{{1, 1}, {8, 8}}, {stretch}),
           other = body("other", GridShape{{1, 1}, {8, 8}}, {stretch});
  one.velocity = {1, 0.5, 0}, one.spin = {0.5, 1, 0.2}, other.transform.translate = {0, 0.05, 1.05},
  other.spin = {0, -0.5, 1};
  other.mass = 0.3;
  Scene scene = scene_of({one, other});
  scene.solver.dt = 0.01, scene.solver.substeps = 10, scene.solver.precision = Precision::Double;
  scene.seams = {sewn_rows("one", RowPin{true}, "other", RowPin{}, 0.2, 0.3)};
  Simulation simulation(scene, {.threads = 1});
  const Measures start = simulation.measure();
  run_for(simulation, scene, 1);
  const Measures end = simulation.measure();
  EXPECT_LT(end.max_seam_gap, 1e-3);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(end.momentum[k], start.momentum[k], 1e-10);
    // A closed seam pulls along its gap, some 1e-4 m, wherever that points.
    EXPECT_NEAR(end.angular_momentum[k], start.angular_momentum[k], 1e-3);
  }
}

TEST(SewnBodies, CloseWhereSeveralParticlesShareAPlace) {
  // 11 particles to 9: two pairs of neighbours are sewn to one each. The last solve of a pair opens the other.
  BodySpec upper = body("upper", GridShape{{0.4, 0.4}, {10, 10}}, {constraint("distance")}),
           lower = body("lower", GridShape{{0.4, 0.4}, {8, 8}}, {constraint("distance")});
  upper.pins = {RowPin{}}, lower.transform.translate = {0, 0, 0.42};
  Scene scene = scene_of({upper, lower});
  scene.gravity = kEarth, scene.solver.dt = 0.01, scene.solver.substeps = 20;
  scene.seams = {sewn_rows("upper", RowPin{true}, "lower", RowPin{}, 0.05)};
  const Simulation simulation = after(scene, 1);
  EXPECT_LT(simulation.measure().max_seam_gap, 1e-6) << "of edges of 4 cm";
  const std::vector<std::string>& notes = simulation.model().notes;
  EXPECT_TRUE(std::ranges::any_of(notes, [](const std::string& note) { return has(note, "2 edges"); }));
  // To the surface no edge is lost.
  scene.seams = {sewn_rows("upper", RowPin{true}, "lower", NearestPin{}, 0.05)};
  scene.seams[0].to = {"lower", {}, true};
  const Simulation attached = after(scene, 1);
  EXPECT_LT(attached.measure().max_seam_gap, 1e-3);
  EXPECT_LT(attached.measure().strain_max, 0.1);
}

TEST(SewnBodies, OfPinsThatHoldThemApartAreRefused) {
  BodySpec one = body("one", GridShape{{1, 1}, {4, 4}}, {constraint("distance")}), other = one;
  other.name = "other", other.transform.translate = {0, 0, 1.05};
  one.pins = {NearestPin{{0, 0, 1}}}, other.pins = {NearestPin{{0, 0, 1.05}}};
  const auto scene = [&] {
    Scene all = scene_of({one, other});
    all.seams = {sewn_rows("one", RowPin{true}, "other", RowPin{}, 0.1)};
    return all;
  };
  EXPECT_TRUE(has(refusal([&] { build_model(scene()); }), "/seams/0")) << "a pair of pinned particles";
  other.transform.translate = {0, 0, 1};
  EXPECT_NO_THROW(build_model(scene())) << "both pins at one place";
  one.pins = {ListPin{{0, 4}}}, other.pins.clear();
  Scene shared = scene();
  shared.seams[0] = {{"one", {}}, {"other", {}}, {}, {{0, 12}, {4, 12}}, 0, 0};
  EXPECT_TRUE(has(refusal([&] { build_model(shared); }), "/seams/0")) << "one particle to two pinned ones";
}

TEST(SewnBodies, CloseInTheTimeThatTheSeamSays) {
  BodySpec one = body("one", GridShape{{1, 1}, {4, 4}}, {constraint("distance")}), other = one;
  other.name = "other", other.transform.translate = {0, 0, 1.4};
  Scene scene = scene_of({one, other});
  scene.solver.dt = 0.01;
  scene.seams = {sewn_rows("one", RowPin{true}, "other", RowPin{}, 0.5, 0.5)};
  Simulation simulation(scene, {.threads = 1});
  for (int step = 1; step <= 70; ++step) {
    simulation.step();
    // Within a thousandth of the gap: what the rest of the sheets leaves to a single iteration.
    EXPECT_NEAR(simulation.measure().max_seam_gap, 0.4 * std::max(0.0, 1 - 0.02 * step), 4e-3) << step;
  }
}

TEST(SewnBodies, OfNoClosingTimeCloseInOneStepAndComeToRest) {
  BodySpec one = body("one", GridShape{{1, 1}, {8, 8}}, {constraint("distance")}), other = one;
  other.name = "other", other.transform.translate = {0, 0, 1.02}, one.damping = other.damping = 0.05;
  Scene scene = scene_of({one, other});
  scene.seams = {sewn_rows("one", RowPin{true}, "other", RowPin{}, 0.05)};
  Simulation simulation(scene, {.threads = 1});
  simulation.step();
  EXPECT_LT(simulation.measure().max_seam_gap, 2e-3);
  double fastest = 0;
  for (int step = 0; step < 120; ++step) simulation.step(), fastest = std::max(fastest, simulation.measure().speed_max);
  EXPECT_LT(fastest, 2) << "2 cm in 1/60 s are 1.2 m/s";
  EXPECT_LT(simulation.measure().speed_max, 0.3);
}

TEST(SewnBodies, GiveWayByTheComplianceOfTheSeam) {
  // A weight of 1 kg on a spring of 1e-3 m/N under a fixed particle: 9.81 mm.
  BodySpec hook = particle({0, 0, 0}), weight = particle({0, 0, 0.001});
  hook.name = "hook", hook.pins = {ListPin{{0}}}, weight.name = "weight";
  Scene scene = scene_of({hook, weight}, kEarth, 0.01, 10);
  scene.wind = Wind{{0, 0, 0}, 5};
  scene.seams = {{{"hook", {}}, {"weight", {}}, {}, {{0, 0}}, 0, 1e-3}};
  const Measures end = after(scene, 5).measure();
  EXPECT_NEAR(end.max_seam_gap, 9.81e-3, 1e-5);
  EXPECT_NEAR(end.elastic, 9.81e-3 * 9.81 / 2, 1e-3) << "J, half of what the weight lost";
}

TEST(SewnBodies, HangOnRingsThatHoldTheSurfaceBetweenItsVertices) {
  ConstraintSpec stretch = constraint("distance");
  stretch.elements = {"edges", "shear"};
  BodySpec curtain = body("curtain", GridShape{{1, 1}, {12, 12}}, {stretch});
  curtain.transform.axis = {1, 0, 0}, curtain.transform.degrees = 90;
  curtain.mass = 0.3, curtain.damping = 0.05;
  BodySpec rings =
      body("rings", MeshDataShape{{{0.13, -0.03, 0.01}, {0.49, -0.05, 0.01}, {0.87, -0.03, 0.01}}, {}, {}, {}});
  rings.pins = {BoxPin{{-9, -9, -9}, {9, 9, 9}}}, rings.damping = 0.05;
  Scene scene = scene_of({curtain, rings});
  scene.gravity = kEarth;
  scene.seams = {sewn_rows("rings", BoxPin{{-9, -9, -9}, {9, 9, 9}}, "curtain", NearestPin{}, 0.02, 0.1)};
  scene.seams[0].to = {"curtain", {}, true};
  const Simulation simulation = after(scene, 3);
  const Measures end = simulation.measure();
  EXPECT_LT(end.max_seam_gap, 5e-3) << "of cells of 83 mm";
  EXPECT_LT(end.strain_max, 0.2);
  double lowest = 0;
  for (const Vec3& x : simulation.positions()) lowest = std::min(lowest, x[1]);
  EXPECT_LT(lowest, -0.98) << "it hangs";
  EXPECT_GT(lowest, -1.1) << "and does not fall";
}

TEST(SewnBodies, CarryAButtonOnASheetThatSwings) {
  ConstraintSpec stretch = constraint("distance");
  stretch.elements = {"edges", "shear"};
  BodySpec sheet = body("sheet", GridShape{{0.5, 0.5}, {10, 10}}, {stretch});
  sheet.mass = 0.1, sheet.pins = {RowPin{}};
  BodySpec button = body("button", GridShape{{0.02, 0.02}, {1, 1}}, {stretch});
  button.mass = 0.002, button.transform.translate = {0.262, 0.002, 0.212};
  Scene scene = scene_of({sheet, button});
  scene.gravity = kEarth;
  scene.seams = {sewn_rows("button", RimPin{}, "sheet", NearestPin{}, 0.01)};
  scene.seams[0].to = {"sheet", {}, true};
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 90; ++step) {
    simulation.step();
    ASSERT_LT(simulation.measure().max_seam_gap, 3e-3) << step << ", of cells of 50 mm";
  }
  // It is still where it was sewn on, at the same share of the sheet.
  const std::vector<Vec3> x = simulation.positions();
  EXPECT_NEAR(length(x[121] - x[4 * 11 + 5]), std::hypot(0.012, 0.012), 0.01);
}

/// A sphere of icosahedral triangles, whole or cut along a jagged line about its equator.
Scene sewn_ball(bool halves) {
  ConstraintSpec skin = with_compliance("distance", 1e-3), pressure = constraint("pressure", 1.3);
  const Mesh sphere = make_mesh(SphereShape{0.5, 3});
  const auto part = [&](const std::string& name, bool upper) {
    MeshDataShape half;
    std::map<int, int> number;
    for (const Quad& face : sphere.faces) {
      const double y = sphere.points[face[0]][1] + sphere.points[face[1]][1] + sphere.points[face[2]][1];
      if ((y > 0.03) != upper) continue;
      Quad own = face;
      for (int k = 0; k < 3; ++k) {
        const auto [at, is_new] = number.try_emplace(face[k], static_cast<int>(number.size()));
        if (is_new) half.points.push_back(sphere.points[face[k]]);
        own[k] = at->second;
      }
      half.faces.push_back(own);
    }
    BodySpec made = body(name, half, {skin});
    made.mass.reset(), made.density = 0.1, made.damping = 0.1;
    return made;
  };
  Scene scene;
  if (halves) {
    scene = scene_of({part("top", true), part("bottom", false)});
    pressure.with = {"bottom"};
    scene.seams = {sewn_rows("top", RimPin{}, "bottom", RimPin{}, 1e-6)};
  } else {
    scene = scene_of({body("ball", SphereShape{0.5, 3}, {skin})});
    scene.bodies[0].mass.reset(), scene.bodies[0].density = 0.1, scene.bodies[0].damping = 0.1;
  }
  scene.bodies[0].constraints.push_back(pressure);
  return scene;
}

TEST(SewnBodies, HoldThePressureOfAWholeBall) {
  const auto radius = [](const Scene& scene) {
    const Simulation simulation = after(scene, 3);
    const Measures end = simulation.measure();
    EXPECT_EQ(end.volume_ratios.size(), 1u);
    EXPECT_NEAR(end.volume_ratios.at(0), 1.3, 0.01);
    EXPECT_LT(end.speed_max, 0.05);
    EXPECT_LT(end.max_seam_gap, 1e-4) << "of edges of 7 cm";
    double least = 1, most = 0;
    for (const Vec3& x : simulation.positions()) least = std::min(least, length(x)), most = std::max(most, length(x));
    return std::array<double, 2>{least, most};
  };
  const auto [least, most] = radius(sewn_ball(false));
  const auto [sewn_least, sewn_most] = radius(sewn_ball(true));
  // At the seam there are two edges for one, twice as stiff: it is drawn in a little.
  EXPECT_NEAR(sewn_least, least, 0.03 * least);
  EXPECT_NEAR(sewn_most, most, 0.02 * most);
}

TEST(SewnBodies, MakeTheLoopOfAnElasticaOfASheet) {
  // Sewn along two of its sides a sheet is a tube. A seam turns freely, so that the sheet takes the shape of an
  // elastica of length L whose ends meet without a moment (half of Euler's figure eight: 2 E(k) = K(k), k^2 = 0.82611):
  // it is k / K(k) L = 0.3916 L long from the seam on, and 0.2569 L across, whatever its rigidity.
  constexpr int n = 32;
  BodySpec sheet = body("sheet", GridShape{{0.25, 1}, {n / 4, n}}, {stiff("distance", {"edges", "shear"})});
  sheet.constraints.push_back(constraint("bending"));
  sheet.constraints[1].rigidity = 0.005, sheet.mass = 0.05;
  // Bent a little, so that it knows to which side to close.
  const Mesh flat = make_mesh(sheet.shape);
  MeshDataShape bent{flat.points, flat.faces, {}, {}};
  for (Vec3& x : bent.points) x[1] = 0.5 * (x[2] - 0.5) * (x[2] - 0.5);
  sheet.shape = bent, sheet.rest = RestPoints{flat.points}, sheet.damping = 0.2;
  Scene scene = scene_of({sheet});
  scene.seams = {
      sewn_rows("sheet", BoxPin{{-1, -1, -0.01}, {2, 2, 0.01}}, "sheet", BoxPin{{-1, -1, 0.99}, {2, 2, 1.01}}, 1.1, 1)};
  const Simulation simulation = after(scene, 10);
  const Measures end = simulation.measure();
  EXPECT_LT(end.max_seam_gap, 1e-4);
  EXPECT_LT(end.speed_max, 0.01);
  EXPECT_LT(end.strain_max, 0.01);
  // In the plane of y and z, from the seam's first particle on.
  const std::vector<Vec3> x = simulation.positions();
  const auto across = [&](const Vec3& along, const Vec3& at) {
    return ((at[1] - x[0][1]) * along[2] - (at[2] - x[0][2]) * along[1]) / std::hypot(along[1], along[2]);
  };
  Vec3 tip{0, 0, 0};
  for (const Vec3& at : x)
    if (const Vec3 to{0, at[1] - x[0][1], at[2] - x[0][2]}; norm(to) > norm(tip)) tip = to;
  double low = 0, high = 0;
  for (const Vec3& at : x) low = std::min(low, across(tip, at)), high = std::max(high, across(tip, at));
  EXPECT_NEAR(norm(tip), 0.3916, 0.004) << "of 32 edges";
  EXPECT_NEAR(high - low, 0.2569, 0.004);
}

/// A pillow of two sheets that keeps itself apart.
Scene pillow_of(int n, bool collides) {
  ConstraintSpec stretch = with_compliance("distance", 1e-3);
  stretch.elements = {"edges", "shear"};
  ConstraintSpec pressure = with_compliance("pressure", 1e-4, 4);
  pressure.with = {"back"};
  BodySpec front = body("front", GridShape{{0.4, 0.4}, {n, n}}, {stretch, pressure}), back = front;
  back.name = "back", back.constraints.pop_back();
  front.transform.translate = {0, 0.02, 0}, back.transform.translate = {0, 0, 0.4};
  back.transform.axis = {1, 0, 0}, back.transform.degrees = 180;
  for (BodySpec* one : {&front, &back}) one->mass = 0.05, one->damping = 0.05;
  Scene scene = scene_of({front, back});
  scene.seams = {sewn_rows("front", RimPin{}, "back", RimPin{}, 0.03, 0.2)};
  if (collides) scene.self_collision = SelfCollision{0.005, 0.2, {}};
  return scene;
}

TEST(SewnBodies, MakeAPillowThatCollidesWithItselfButNotAtItsSeam) {
  Simulation simulation(pillow_of(16, true), {.threads = 1});
  for (int step = 0; step < 180; ++step) {
    simulation.step();
    if (step % 5 == 0) {
      ASSERT_EQ(simulation.measure().crossings, 0) << step;
    }
  }
  const Measures end = simulation.measure();
  EXPECT_LT(end.max_seam_gap, 1e-3)
      << "a fifth of the thickness, which would otherwise keep the sides apart: a fold at a "
         "corner may hold them open by as much, sometimes";
  EXPECT_NEAR(end.volume_ratios.at(0), 4, 0.1);
  EXPECT_GT(end.self_contacts, 0) << "at the folds of the rim";
  // Nothing acts from outside. What presses on itself for good turns (accuracy.md): by 0.2 rad/s here.
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(end.momentum[k], 0, 1e-7);
    EXPECT_NEAR(end.angular_momentum[k], 0, 1e-3);
  }
}

TEST(SewnBodies, MayCrossAtTheirSeamAtTheStart) {
  Scene scene = sewn_cloth(8, true, {constraint("distance")});
  scene.bodies[1].transform.degrees = 45;  // its upper row reaches through the lowest cells of the other half
  scene.bodies[1].transform.translate = {0, -0.48, -0.01};
  scene.seams[0].within = 0.05;
  scene.self_collision = SelfCollision{0.01, 0, {}};
  EXPECT_NO_THROW(Simulation(scene, {.threads = 1}));
  scene.seams.clear();
  EXPECT_THROW(Simulation(scene, {.threads = 1}), InputError);
}

INSTANTIATE_TEST_SUITE_P(
    Seams, SameBits,
    testing::Values(SameBitsScene{"pillow",
                                  [](const TemporaryFolder&) { return pillow_of(8, true); },
                                  30,
                                  {5, 14},
                                  [](const Simulation& end) { EXPECT_GT(end.measure().volume_ratios.at(0), 1); }},
                    SameBitsScene{"closing",
                                  [](const TemporaryFolder&) { return pillow_of(40, false); },
                                  20,
                                  {3, 13},
                                  [](const Simulation& end) { EXPECT_LT(end.measure().max_seam_gap, 2e-3); }},
                    SameBitsScene{"hung",
                                  [](const TemporaryFolder&) { return sewn_cloth(40, true, {constraint("distance")}); },
                                  20,
                                  {7}}),
    name_of_scene);

}  // namespace
}  // namespace malha
