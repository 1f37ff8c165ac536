// SPDX-License-Identifier: Apache-2.0
// Bodies on exact shapes of the environment: nothing passes, and friction, restitution, starts and motion are those of
// meshes and of textbooks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "host/environment/moving_shape.h"
#include "host/fields/contacts.h"
#include "host/report/launches.h"
#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

EnvironmentSpec exact_object(const std::string& name, const Shape& shape, double friction = 0, double restitution = 0) {
  EnvironmentSpec object;
  object.name = name, object.shape = shape, object.friction = friction, object.restitution = restitution;
  return object;
}

const SphereShape kExactBall{0.4, std::nullopt};
const Shape kEveryShape[]{PlaneShape{}, kExactBall, CapsuleShape{{-0.5, 0, 0}, {0.5, 0, 0}, 0.3},
                          BoxShape{{1, 0.6, 0.8}, std::nullopt}, CylinderShape{{0, -0.3, 0}, {0, 0.3, 0}, 0.5}};
const char* const kNamesOfShapes[]{"Plane", "Sphere", "Capsule", "Box", "Cylinder"};

/// Depth of the deepest particle in any exact shape of the simulation, by the shapes themselves; below 0 outside.
double depth_in_shapes(const Simulation& simulation) {
  double deepest = -INFINITY;
  for (const EnvironmentMesh& object : simulation.model().environment) {
    const MovingShape shape = moving_shape(*object.exact, object.spec, simulation.time(), simulation.time());
    for (const Vec3& x : simulation.positions())
      deepest = std::max(deepest,
                         -distance_to(shape.shape, to_local(shape.before, Vector3<double>{x[0], x[1], x[2]})).distance);
  }
  return deepest;
}

/// Distance of a point from a shape, m.
double distance_from(const Shape& shape, const Vec3& x) {
  const PlacedShape placed = place(shape, {});
  return distance_to(placed.shape, to_local(placed.pose, {x[0], x[1], x[2]})).distance;
}

class OnEveryShape : public testing::TestWithParam<std::tuple<int, Precision>> {
 protected:
  Shape shape() const { return kEveryShape[std::get<0>(GetParam())]; }
  Precision precision() const { return std::get<1>(GetParam()); }
  double rounding() const { return precision() == Precision::Float ? 1e-6 : 1e-12; }
};
INSTANTIATE_TEST_SUITE_P(All, OnEveryShape,
                         testing::Combine(testing::Range(0, 5), testing::Values(Precision::Float, Precision::Double)),
                         [](const auto& info) {
                           return std::string(kNamesOfShapes[std::get<0>(info.param)]) +
                                  (std::get<1>(info.param) == Precision::Float ? "Float" : "Double");
                         });

TEST_P(OnEveryShape, NothingPassesAtAnySpeed) {
  // Particles above and beside the shape fly at it, and past it, from all sides; some of them spin with the shape.
  for (const double speed : {1.0, 30.0, 1000.0, 30000.0}) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1, 1);
    Scene scene = scene_of({}, kEarth, 1.0 / 60, 2, precision());
    for (int k = 0; k < 60; ++k) {
      Vec3 at{2 * any(random), 1 + any(random), 2 * any(random)};
      BodySpec body = particle(at);
      body.name += std::to_string(k);
      const Vec3 to{0.5 * any(random), 0.5 * any(random), 0.5 * any(random)}, way = to - at;
      for (int j = 0; j < 3; ++j) body.velocity[j] = speed * way[j] / length(way);
      if (length(at) > 0.9) scene.bodies.push_back(body);
    }
    scene.environment = {exact_object("it", shape(), 0.3, 0.4)};
    scene.environment[0].push_out = true;
    Simulation simulation(scene, {.threads = 1});
    int touching = 0;
    for (int step = 0; step < 30; ++step) {
      simulation.step();
      touching += simulation.measure().contacts;
      // Positions beyond some metres are rounded by more than the thickness is worth; those have passed beside it.
      ASSERT_LE(depth_in_shapes(simulation), rounding()) << speed << " m/s, step " << step;
      ASSERT_LE(simulation.measure().penetration_max, rounding());
    }
    if (speed < 1000) {
      EXPECT_GT(touching, 0);
    }
  }
}

TEST_P(OnEveryShape, AShapeThatMovesFastTakesParticlesAlongAndPassesNone) {
  for (const double speed : {1.0, 100.0, 3000.0}) {
    BodySpec body;
    body.name = "cloud", body.shape = LatticeShape{{-0.3, 1, -0.3}, {0.3, 1.2, 0.3}, {6, 3, 6}}, body.mass = 1;
    Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60, 3, precision());
    scene.environment = {exact_object("it", shape())};
    Keyframe end;
    end.time = 1, end.translate = {0, speed, 0};
    scene.environment[0].motion = {Keyframe{}, end};
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 20; ++step) {
      simulation.step();
      const double far = speed * simulation.time();
      ASSERT_LE(depth_in_shapes(simulation), std::max(1e-12, rounding() * far)) << speed << " m/s, step " << step;
    }
    if (speed >= 100 && shape().index() == kEveryShape[0].index()) {
      for (const Vec3& x : simulation.positions()) EXPECT_GT(x[1], speed * simulation.time());
    }
  }
}

TEST_P(OnEveryShape, AParticleComesToRestAtTheThickness) {
  Scene scene = scene_of({particle({0, 1, 0})}, kEarth, 1.0 / 60, 10, precision());
  scene.environment = {exact_object("it", shape(), 0.5)};
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 3);
  EXPECT_NEAR(-depth_in_shapes(simulation), 0.005, 1e-6);
  // On the round ones it stands on the top, which is unstable, but exactly.
  EXPECT_LT(simulation.measure().speed_max, 1e-4);
  EXPECT_EQ(simulation.measure().contacts, 1);
}

TEST_P(OnEveryShape, ABodyThatStartsInsideIsRefusedOrMovedOut) {
  BodySpec body = particle({0.03, -0.02, 0.01});
  body.shape = LatticeShape{{0.03, -0.02, 0.01}, {0.05, -0.01, 0.02}, {2, 2, 2}};
  Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60, 10, precision());
  scene.environment = {exact_object("rock", shape())};
  const std::string said = refusal([&] { Simulation(scene, {.threads = 1}); });
  EXPECT_TRUE(has(said, "/environment/0: found particle") && has(said, "inside 'rock' (8 particles")) << said;
  scene.environment[0].push_out = true;
  Simulation simulation(scene, {.threads = 1});
  ASSERT_EQ(simulation.model().notes.size(), 1u);
  EXPECT_LE(depth_in_shapes(simulation), 0);
  run_for(simulation, scene, 0.2);
  EXPECT_LT(simulation.measure().speed_max, 1e-4) << "it is moved without velocity";
}

TEST_P(OnEveryShape, AParticleThatStartsNearerThanTheThicknessKeepsItsDistance) {
  Scene scene = scene_of({}, kEarth, 1.0 / 60, 10, precision());
  scene.environment = {exact_object("it", shape(), 0.5)};
  const double height = 1 - distance_from(shape(), {0, 1, 0});
  for (const double depth : {0.002, 0.005, 0.007}) {  // above, on and below the surface
    scene.bodies = {particle({0, height + 0.005 - depth, 0})};
    Simulation simulation(scene, {.threads = 1});
    run_for(simulation, scene, 0.5);
    EXPECT_NEAR(simulation.positions()[0][1], height + 0.005 - depth, 1e-6) << depth;
    EXPECT_LT(simulation.measure().speed_max, 1e-4);
    EXPECT_NEAR(simulation.measure().penetration_max, std::max(0.0, depth - 0.005), 1e-6);
  }
}

TEST_P(OnEveryShape, ARunGoesOnFromItsStateWithTheSameBits) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1.2, 1.2}, {24, 24}}, sheet.density = 0.2;
  sheet.transform.translate = {-0.6, 0.55, -0.6}, sheet.constraints = {stiff("distance", {"edges", "shear"})};
  const BodySpec near = particle({0.9, 0.002, 0.9});  // nearer to the ground than the thickness
  Scene scene = scene_of({sheet, near}, kEarth, 1.0 / 60, 10, precision());
  scene.environment = {exact_object("it", shape(), 0.4), exact_object("ground", PlaneShape{}, 0.4)};
  Simulation whole(scene, {.threads = 1}), resumed(scene, {.threads = 1});
  run_for(whole, scene, 0.4);
  resumed.restore_state(whole.save_state());
  run_for(whole, scene, 0.3), run_for(resumed, scene, 0.3);
  EXPECT_GT(whole.measure().contacts, 0);
  EXPECT_NEAR(whole.positions().back()[1], 0.002, 1e-6) << "its overlap is part of the state";
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
}

TEST(ShapeContact, ThreadsDoNotChangeTheBits) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    BodySpec rain;
    rain.name = "rain", rain.mass = 1, rain.velocity = {0.5, -3, 0.2};
    rain.shape = LatticeShape{{-2, 0.8, -2}, {2, 1.2, 2}, {25, 8, 25}};  // more than one thread takes
    Scene scene = scene_of({rain}, kEarth, 1.0 / 60, 4, precision);
    for (int k = 0; k < 5; ++k) {
      scene.environment.push_back(exact_object(kNamesOfShapes[k], kEveryShape[k], 0.4, 0.3));
      if (k > 0) scene.environment[k].transform.translate = {k % 2 - 0.5, 0.1 * k, k / 2 - 1.0};
    }
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 3}) {
      Simulation simulation(scene, {.threads = threads});
      int touching = 0;
      for (int step = 0; step < 24; ++step) simulation.step(), touching += simulation.measure().contacts;
      EXPECT_GT(touching, 1000);
      EXPECT_LE(depth_in_shapes(simulation), 1e-6);
      hashes.push_back(simulation.state_hash());
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
  }
}

TEST(ShapeContact, FrictionOnASlopeHoldsOrSlidesAsCoulombSays) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const double mu : {0.0, 0.3, 0.35, 0.5}) {
      constexpr double degrees = 18, slope = degrees * kPi / 180;  // tan = .325
      const double up = 0.005;
      Scene scene =
          scene_of({particle({-up * std::sin(slope), up * std::cos(slope), 0})}, kEarth, 1.0 / 60, 20, precision);
      scene.environment = {exact_object("slope", PlaneShape{}, mu)};
      scene.environment[0].transform.axis = {0, 0, 1}, scene.environment[0].transform.degrees = degrees;
      const Simulation simulation = after(scene, 1);
      const double a = std::max(0.0, kG * (std::sin(slope) - mu * std::cos(slope)));
      // v is exact; the path has the step's first-order error, a h / 2 a second.
      EXPECT_NEAR(length(simulation.velocities()[0]), a, 1e-3 * kG) << mu;
      const Vec3 way = simulation.positions()[0] - Vec3{-up * std::sin(slope), up * std::cos(slope), 0};
      EXPECT_NEAR(length(way), a / 2, a / 1200 + 1e-6) << mu;
    }
}

TEST(ShapeContact, ABallRisesToTheSquareOfTheRestitutionTimesItsHeight) {
  for (const int k : {0, 1, 3}) {
    Scene scene = scene_of({particle({0, 2, 0})}, kEarth, 1.0 / 60, 20);
    scene.environment = {exact_object("it", kEveryShape[k], 0, 0.6)};
    Simulation simulation(scene, {.threads = 1});
    const double rest = 2 - distance_from(kEveryShape[k], {0, 2, 0}) + 0.005, drop = 2 - rest;
    const double falls = std::sqrt(2 * drop / kG), rises = 0.6 * kG * falls / kG;
    double highest = 0;
    while (simulation.time() < falls + 2 * rises) {
      simulation.step();
      if (simulation.time() > falls + 0.1) highest = std::max(highest, simulation.positions()[0][1]);
    }
    // Within the motion of a step at the top, and the substep in which it hits.
    EXPECT_NEAR(highest - rest, 0.36 * drop, 0.02 * drop) << kNamesOfShapes[k];
  }
}

TEST(ShapeContact, ATurningTableTakesARoughParticleAlong) {
  for (const Shape& table : {Shape(BoxShape{{2, 0.2, 2}, std::nullopt}),
                             Shape(CylinderShape{{0, -0.1, 0}, {0, 0.1, 0}, 1}), Shape(PlaneShape{})}) {
    const double top = std::holds_alternative<PlaneShape>(table) ? 0 : 0.1, turn = kPi;  // rad/s
    Scene scene = scene_of({particle({0.2, top + 0.005, 0}, {0, 0, -turn * 0.2})}, kEarth, 1.0 / 60, 10);
    scene.environment = {exact_object("table", table, 1)};
    Keyframe end;
    end.time = 10, end.degrees = 1800;
    scene.environment[0].motion = {Keyframe{}, end};
    const Simulation simulation = after(scene, 2);  // once around; it needs mu > omega^2 r / g = .2
    // Each substep ends where the surface is: it moves along the chord, and drifts outwards by less than friction's
    // creep of one substep.
    EXPECT_NEAR(simulation.positions()[0][0], 0.2, 2e-3);
    EXPECT_NEAR(simulation.positions()[0][2], 0, 5e-3);
    EXPECT_NEAR(length(simulation.velocities()[0]), turn * 0.2, 1e-2);
  }
}

TEST(ShapeContact, ASphereDropsClothAsItsFineMeshDoes) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {20, 20}}, sheet.density = 0.2;
  sheet.transform.translate = {-0.5, 0.45, -0.5}, sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Scene exact = scene_of({sheet}, kEarth, 1.0 / 60, 10), meshed = exact;
  exact.environment = {exact_object("ball", kExactBall, 0.3)};
  meshed.environment = {exact_object("ball", SphereShape{0.4, 6}, 0.3)};
  const std::vector<Vec3> a = after(exact, 0.3).positions(), b = after(meshed, 0.3).positions();
  double apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) apart = std::max(apart, length(a[i] - b[i]));
  // Triangles of 13 mm have a sagitta of .05 mm; folds amplify it.
  EXPECT_LT(apart, 5e-3);
}

/// A room of exact and meshed walls, one of which presses in and back.
Scene mixed_room(Precision precision) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-0.4, 0.4);
  Scene scene = scene_of({}, kEarth, 1.0 / 60, 5, precision);
  for (int k = 0; k < 40; ++k) {
    BodySpec body =
        particle({any(random), any(random), any(random)}, {40 * any(random), 40 * any(random), 40 * any(random)});
    body.name += std::to_string(k);
    scene.bodies.push_back(body);
  }
  for (int k = 0; k < 6; ++k) {
    const int axis = k / 2;
    const double sign = k % 2 == 0 ? 1 : -1;
    EnvironmentSpec wall = exact_object("wall " + std::to_string(k), PlaneShape{}, 0.2, 0.5);
    wall.thickness = 0.003;
    if (k % 3 == 0) {  // two walls of triangles, one of which faces the other two kinds
      Vec3 size{1.6, 1.6, 1.6};
      size[axis] = 0.4;
      wall.shape = BoxShape{size, {{3, 3, 3}}};
      wall.transform.translate[axis] = sign * 0.7;
    } else {
      wall.transform.translate[axis] = sign * 0.5;
      // The normal, +y, is turned to -sign along the axis.
      wall.transform.axis = axis == 0 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
      wall.transform.degrees = axis == 0 ? sign * 90 : axis == 1 ? (sign > 0 ? 180 : 0) : -sign * 90;
    }
    if (k == 1)
      for (int quarter = 0; quarter < 20; ++quarter) {
        Keyframe frame;
        frame.time = 0.125 * quarter, frame.translate = {quarter % 2 == 0 ? 0 : 0.6, 0, 0};
        wall.motion.push_back(frame);
      }
    scene.environment.push_back(wall);
  }
  return scene;
}

TEST(ShapeContact, WallsOfBothKindsKeepParticlesInTheirRoom) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const Scene scene = mixed_room(precision);
    Simulation simulation(scene, {.threads = 1}), again(scene, {.threads = 3});
    for (int step = 0; step < 120; ++step) {
      simulation.step(), again.step();
      const Measures now = simulation.measure();
      ASSERT_LE(now.penetration_max, precision == Precision::Float ? 1e-6 : 1e-12) << step;
      for (const Vec3& x : simulation.positions())
        for (int k = 0; k < 3; ++k) ASSERT_LT(std::abs(x[k]), 0.5) << step;
    }
    EXPECT_EQ(simulation.state_hash(), again.state_hash());
  }
}

TEST(ShapeContact, ClothThatCollidesWithItselfIsNotPushedIntoShapes) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{0.6, 0.6}, {24, 24}}, sheet.density = 0.2;
  sheet.transform.translate = {-0.3, 0.4, -0.3}, sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 10, Precision::Float);
  SelfCollision self;
  self.thickness = 0.008;
  scene.self_collision = self;
  scene.environment = {exact_object("ground", PlaneShape{}, 0.4),
                       exact_object("rod", CapsuleShape{{-0.3, 0.15, 0}, {0.3, 0.15, 0}, 0.06}, 0.3),
                       exact_object("press", BoxShape{{0.2, 0.2, 0.6}, std::nullopt}, 0.3)};
  scene.environment[2].transform.translate = {0.6, 0.105, 0};
  Keyframe start, end;
  end.time = 1.5, end.translate = {-0.5, 0, 0}, start.time = 0.5;
  scene.environment[2].motion = {start, end};
  Simulation simulation(scene, {.threads = 2});
  double deepest = 0;
  for (int step = 0; step < 120; ++step) {
    simulation.step();
    const Measures now = simulation.measure();
    deepest = std::max(deepest, now.penetration_max);
    ASSERT_EQ(now.crossings, 0) << step;
  }
  EXPECT_LE(deepest, 1e-6);
}

TEST(ShapeContact, NoContactIsDetectedWhileAllIsFarAbove) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {10, 10}}, sheet.density = 0.2;
  sheet.transform.translate = {0, 3, 0}, sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 10);
  scene.environment = {exact_object("ground", PlaneShape{}, 0.4)};
  const auto launches = [&](Simulation& simulation, const std::string& kernel) {
    simulation.step();  // of the first step a simulation keeps the launches itself
    const LaunchTrace trace;
    simulation.step();
    const std::vector<Launches> all = trace.list();
    return std::ranges::any_of(all, [&](const Launches& of) { return has(of.kernel, kernel); });
  };
  Scene low = scene;
  low.bodies[0].transform.translate = {0, 0.01, 0};
  Simulation simulation(scene, {.threads = 1}), near(low, {.threads = 1});
  EXPECT_TRUE(launches(simulation, "MeasureShapeClearance"));
  EXPECT_FALSE(launches(simulation, "DetectShapeContacts"));
  EXPECT_TRUE(launches(near, "DetectShapeContacts"));
  // It lands as without that rule: a callback turns the rule off.
  Simulation detects(scene, {.threads = 1, .interactive = true});
  while (detects.time() < 1.5) simulation.step(), detects.step([](int, double) {});
  EXPECT_NEAR(simulation.positions()[0][1], 0.005, 1e-3);
  EXPECT_NEAR(detects.positions()[0][1], 0.005, 1e-3);
  EXPECT_EQ(simulation.measure().penetration_max, 0);
}

TEST(ShapeContact, AVisualFieldOfContactsHasThePointOnTheShape) {
  Scene scene = scene_of({particle({0.003, 0.405, 0})}, {0, 0, 0}, 1.0 / 60);
  scene.environment = {exact_object("ball", kExactBall)};
  const Simulation simulation(scene, {.threads = 1});
  const std::vector<ContactPoint> all =
      Contacts(simulation.model())(simulation.positions(), simulation.model().environment, 0);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_NEAR(length(all[0].at), 0.4, 1e-12);
  EXPECT_NEAR(all[0].distance, std::hypot(0.003, 0.405) - 0.4, 1e-12);
}

TEST(ShapeContact, AnExactBoxHasItsEdges) {
  // A sheet of few particles hangs over a bar whose edges lie between them.
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {4, 4}}, sheet.density = 0.2;
  sheet.transform.translate = {-0.55, 0.3, -0.55}, sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 10);
  scene.environment = {exact_object("bar", BoxShape{{0.1, 0.1, 2}, std::nullopt}, 0.5)};
  scene.environment[0].edges = true;
  Simulation simulation(scene, {.threads = 1});
  int touching = 0;
  for (int step = 0; step < 60; ++step) {
    simulation.step();
    const Measures now = simulation.measure();
    touching = std::max(touching, now.edge_contacts);
    ASSERT_EQ(now.crossings, 0) << step;
  }
  EXPECT_GT(touching, 0);
}

std::string refused_object(const std::string& object) {
  const std::string text =
      R"({"name": "s", "solver": {"type": "pbd"}, "duration": 1, "bodies": [{"name": "b", "mass": 1,
      "shape": {"lattice": {"min": [0, 1, 0], "max": [0, 1, 0], "count": [1, 1, 1]}}}], "environment": [{"name": "o", )" +
      object + "}]}";
  return refusal([&] { parse_scene(text, "s.json", ""); });
}

TEST(ShapeContact, WhatAnExactShapeCannotBeIsRefused) {
  EXPECT_EQ(refused_object(R"("shape": {"plane": {}}, "sides": "solid")"), "");
  EXPECT_TRUE(has(refused_object(R"("shape": {"plane": {}}, "sides": "two_sided")"),
                  "/environment/0/sides: found \"two_sided\""));
  EXPECT_TRUE(has(refused_object(R"("shape": {"sphere": {"radius": 1}}, "transform": {"scale": [1, 2, 1]})"),
                  "/environment/0/transform/scale: found different scales of an exact round shape"));
  EXPECT_EQ(refused_object(R"("shape": {"box": {"size": [1, 1, 1]}}, "transform": {"scale": [1, 2, 1]})"), "");
  EXPECT_TRUE(has(refused_object(R"("shape": {"capsule": {"from": [0, 0, 0], "to": [0, 0, 0], "radius": 1}})"),
                  "/environment/0/shape/capsule/to: found the same point as 'from'"));
  EXPECT_TRUE(has(refused_object(R"("shape": {"cylinder": {"from": [0, 0, 0], "to": [0, 1, 0], "radius": 0}})"),
                  "/environment/0/shape/cylinder/radius"));
  EXPECT_TRUE(has(refused_object(R"("shape": {"sphere": {"radius": 1}}, "edges": true)"),
                  "/environment/0/edges: found 'edges' of an exact shape that is not a box"));
  Scene scene = scene_of({particle({0, 0, 0})}, {0, 0, 0}, 0.01);
  scene.bodies[0].shape = kExactBall;
  EXPECT_TRUE(has(refusal([&] { Simulation(scene, {.threads = 1}); }), "a sphere without 'subdivisions'"));
}

TEST(ShapeContact, AnExactShapeIsWrittenAsItWasRead) {
  for (const Shape& shape : kEveryShape) {
    Scene scene = scene_of({particle({0, 3, 0})}, {0, 0, 0}, 0.01);
    scene.environment = {exact_object("it", shape, 0.1)};
    const std::string text = to_json(scene);
    EXPECT_EQ(to_json(parse_scene(text, "s.json", "")), text);
    EXPECT_TRUE(is_exact(parse_scene(text, "s.json", "").environment[0].shape));
  }
}

}  // namespace
}  // namespace malha
