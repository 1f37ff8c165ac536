// SPDX-License-Identifier: Apache-2.0
// Contacts keep what they remember where a scene is replaced while it runs: the same scene changes nothing, and what
// comes and goes elsewhere changes nothing for what stays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/solver/solver.h"
#include "tests/numbers.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr int kCells = 11, kParticles = (kCells + 1) * (kCells + 1);

/// A sheet of 0.5 x 0.5 m and 0.1 kg about a point, whose inner particles are off their lattice and whose diagonals run
/// either way.
BodySpec irregular_sheet_at(const std::string& name, const Vec3& centre, unsigned seed) {
  Random random(seed);
  MeshDataShape mesh;
  constexpr double cell = 0.5 / kCells;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const bool inner = i > 0 && j > 0 && i < kCells && j < kCells;
      const double dx = inner ? random(-0.25, 0.25) : 0, dz = inner ? random(-0.25, 0.25) : 0;
      mesh.points.push_back({(i + dx) * cell - 0.25, 0, (j + dz) * cell - 0.25});
    }
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const int a = j * (kCells + 1) + i, b = a + 1, c = a + kCells + 1, d = c + 1;
      if (random.below(2) == 0)
        mesh.faces.push_back({a, c, b, -1}), mesh.faces.push_back({b, c, d, -1});
      else
        mesh.faces.push_back({a, c, d, -1}), mesh.faces.push_back({a, d, b, -1});
    }
  BodySpec body;
  body.name = name, body.mass = 0.1, body.shape = mesh, body.transform.translate = centre;
  body.constraints = {compliant("distance", 1e-5, {"edges"})};
  return body;
}

EnvironmentSpec object_at(const std::string& name, const Shape& shape, const Vec3& at) {
  EnvironmentSpec object;
  object.name = name, object.shape = shape, object.transform.translate = at;
  object.thickness = 0.01, object.friction = 0.3;
  return object;
}
const Shape kBall = SphereShape{0.2, 2}, kExactBall = SphereShape{0.2, std::nullopt};
const Shape kBlock = BoxShape{{0.3, 0.2, 0.3}, std::array{2, 2, 2}};

/// A scene that is replaced while it runs.
struct Replaced {
  std::string name;
  Scene scene;
  std::function<void(Simulation&, int step)> drive = {};  // before each step
};

Replaced over(const std::string& name, const EnvironmentSpec& object) {
  Scene scene = scene_of({irregular_sheet_at("sheet", {0.03, 0.215, -0.02}, 5)}, kEarth, 0.01, 5);
  scene.environment = {object};
  return {name, scene};
}

Replaced with_edges() {
  EnvironmentSpec block = object_at("object", kBlock, {0, 0.1, 0});
  block.edges = true;
  return over("edges", block);
}

/// The vertices of the object bulge while the sheet lies on it.
Replaced on_deforming() {
  EnvironmentSpec ball = object_at("object", kBall, {0, 0, 0});
  ball.animation.emplace().from_code = true;
  Replaced made = over("deforming", ball);
  const auto mesh = std::make_shared<Simulation>(scene_of({[] {
                                                            BodySpec body;
                                                            body.name = "ball", body.shape = kBall, body.mass = 1;
                                                            return body;
                                                          }()},
                                                          {0, 0, 0}, 0.01));
  made.drive = [mesh](Simulation& simulation, int step) {
    std::vector<Vec3> points = mesh->positions();
    for (Vec3& at : points) at[1] *= 1 + 0.05 * std::sin(0.3 * step);
    simulation.set_vertices("object", points);
  };
  return made;
}

Replaced in_a_pile(double apart) {
  Scene scene = scene_of(
      {irregular_sheet_at("sheet", {0, 0.01, 0}, 5), irregular_sheet_at("second", {0.04, 0.01 + apart, 0.03}, 6),
       irregular_sheet_at("third", {-0.03, 0.01 + 2 * apart, 0.02}, 7)},
      kEarth, 0.01, 5);
  scene.environment = {object_at("object", PlaneShape{}, {0, 0, 0})};
  scene.self_collision.emplace().thickness = 0.008, scene.self_collision->friction = 0.2;
  return {"pile", scene};
}

/// A sheet of which some particles are nearer to the object than its thickness from the start, and are pressed onto it.
Replaced too_near(const Shape& shape, const std::string& name) {
  Replaced made = over(name, object_at("object", shape, {0, 0, 0}));
  made.scene.bodies[0].transform.translate = {0.03, 0.206, -0.02};
  return made;
}

Replaced asleep() {
  Scene scene = scene_of({irregular_sheet_at("sheet", {0, 0.01, 0}, 5)}, kEarth, 0.01, 5);
  scene.environment = {object_at("object", PlaneShape{}, {0, 0, 0})};
  scene.sleep.emplace().after = 0.2, scene.sleep->speed = 0.05;
  return {"asleep", scene};
}

Replaced with_levels() {
  Replaced made{"levels", scene_of({irregular_sheet_at("sheet", {0, 0, 0}, 5)}, kEarth, 0.01, 10)};
  made.scene.bodies[0].pins = {ListPin{{0, kCells}}};
  made.scene.solver.levels = 1, made.scene.solver.levels_interval = 1;
  return made;
}

std::vector<Replaced> in_contact() {
  return {over("mesh", object_at("object", kBall, {0, 0, 0})),
          over("exact", object_at("object", kExactBall, {0, 0, 0})),
          with_edges(),
          on_deforming(),
          in_a_pile(0.012),
          in_a_pile(0.005),
          too_near(kBall, "near_mesh"),
          too_near(kExactBall, "near_exact")};
}
std::vector<Replaced> of_all_kinds() {
  std::vector<Replaced> all = in_contact();
  all.push_back(asleep()), all.push_back(with_levels());
  return all;
}

/// Calls test(scene) for each scene in each precision, by both methods.
void in_each_way(std::vector<Replaced> all, const std::function<void(const Replaced&)>& test) {
  for (Replaced& one : all)
    for (const Precision precision : {Precision::Double, Precision::Float})
      for (const std::string type : {"pbd", "desbrun"}) {
        if (type == "desbrun" && one.name == "levels") continue;
        SCOPED_TRACE(one.name + " by " + type + (precision == Precision::Float ? " in float" : " in double"));
        one.scene.solver.type = type, one.scene.solver.precision = precision;
        test(one);
      }
}

void steps(const Replaced& of, Simulation& simulation, int count) {
  for (; count > 0; --count) {
    if (of.drive) of.drive(simulation, static_cast<int>(simulation.steps()));
    simulation.step();
  }
}

TEST(SetSceneAgain, ChangesNothingWhateverIsInIt) {
  in_each_way(of_all_kinds(), [](const Replaced& of) {
    Simulation set(of.scene, {.threads = 1}), alone(of.scene, {.threads = 1});
    for (int round = 0; round < 4; ++round) {
      steps(of, set, 7), steps(of, alone, 7);
      set.set_scene(set.scene());
      EXPECT_EQ(set.save_state(), alone.save_state());
    }
    steps(of, set, 15), steps(of, alone, 15);
    EXPECT_EQ(set.state_hash(), alone.state_hash());
  });
}

TEST(SetSceneAgain, ChangesNothingInAScene) {
  for (const char* name : {"rotating_sphere", "folded_sheet", "pillow", "soft_bunny", "turning_flag", "desbrun_sheet",
                           "sheet_shear", "at_rest", "ramp", "cantilever", "carried_sheet", "thin_wall"}) {
    SCOPED_TRACE(name);
    const Scene scene = load_shipped(name);
    Simulation set(scene, {.threads = 2}), alone(scene, {.threads = 2});
    for (int step = 0; step < 6; ++step) set.step(), alone.step();
    set.set_scene(scene);
    for (int step = 0; step < 6; ++step) set.step(), alone.step();
    EXPECT_EQ(set.state_hash(), alone.state_hash());
  }
}

TEST(SetSceneAgain, MayChangeWhatNoStepDependsOn) {
  const Replaced of = in_a_pile(0.012);
  Simulation set(of.scene, {.threads = 1, .interactive = true}), alone(of.scene, {.threads = 1, .interactive = true});
  for (Simulation* one : {&set, &alone}) steps(of, *one, 10), one->pull(3, {0, 0.4, 0}, 1e-2);
  Scene scene = set.scene();
  scene.name = "another", scene.duration = 77;
  set.set_scene(scene);
  EXPECT_EQ(set.scene().name, "another");
  EXPECT_EQ(set.scene().duration, 77);
  EXPECT_EQ(set.handles().size(), 1u);
  steps(of, set, 10), steps(of, alone, 10);
  EXPECT_EQ(set.state_hash(), alone.state_hash());
}

// Another object is too far away to matter, but the layout is another one.
TEST(SetSceneWithMore, ObjectsFarAwayLeavesTheBitsOfContacts) {
  in_each_way(in_contact(), [](const Replaced& of) {
    Simulation set(of.scene, {.threads = 1}), alone(of.scene, {.threads = 1});
    steps(of, set, 25), steps(of, alone, 25);
    Scene more = set.scene();
    for (EnvironmentSpec far : {object_at("far", kBall, {30, 0, 0}), object_at("far too", kExactBall, {40, 0, 0})})
      more.environment.insert(more.environment.begin(), far);  // before the one that stays
    set.set_scene(more);
    EXPECT_EQ(set.state_hash(), alone.state_hash());
    steps(of, set, 20), steps(of, alone, 20);
    EXPECT_EQ(set.state_hash(), alone.state_hash()) << "with them";
    more.environment.erase(more.environment.begin(), more.environment.begin() + 2);
    set.set_scene(more);
    steps(of, set, 20), steps(of, alone, 20);
    EXPECT_EQ(set.state_hash(), alone.state_hash()) << "and without them";
  });
}

double farthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b, std::size_t count) {
  double most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, length(a[i] - b[i]));
  return most;
}

// The order of particles and constraints of the bodies that stay is the same. What holds all bodies together is another
// one: the filter of Desbrun's method, whose factor rounds otherwise, and the search of self-collision, which lists the
// pairs in another order, in which they push each other.
TEST(SetSceneWithMore, BodiesFarAwayLeavesTheBitsOfContacts) {
  in_each_way(in_contact(), [](const Replaced& of) {
    const bool piled = of.name == "pile", filtered = of.scene.solver.type == "desbrun";
    const double most = piled ? 0.03 : filtered ? 1e-12 : 0;  // m/s
    Simulation set(of.scene, {.threads = 1}), alone(of.scene, {.threads = 1});
    steps(of, set, 25), steps(of, alone, 25);
    const std::size_t count = set.positions().size();
    Scene more = set.scene();
    more.bodies.push_back(irregular_sheet_at("far", {10, 5, 0}, 9));
    set.set_scene(more);
    EXPECT_EQ(farthest(set.positions(), alone.positions(), count), 0);
    EXPECT_EQ(farthest(set.velocities(), alone.velocities(), count), 0);
    steps(of, set, 20), steps(of, alone, 20);
    EXPECT_LE(farthest(set.velocities(), alone.velocities(), count), most) << "with it";
    more.bodies.pop_back();
    set.set_scene(more);
    steps(of, set, 20), steps(of, alone, 20);
    EXPECT_LE(farthest(set.velocities(), alone.velocities(), count), most) << "and without it";
    if (piled) {
      EXPECT_LT(farthest(set.positions(), alone.positions(), count), 2e-3);
      EXPECT_EQ(set.measure().crossings, 0);
    }
  });
}

TEST(SetSceneWithMore, BodiesBeforeOthersLeavesThemWhereTheyAre) {
  for (const Replaced& of : in_contact()) {
    if (of.name == "pile") continue;
    SCOPED_TRACE(of.name);
    Simulation set(of.scene, {.threads = 1}), alone(of.scene, {.threads = 1});
    steps(of, set, 25), steps(of, alone, 25);
    Scene more = set.scene();
    more.bodies.insert(more.bodies.begin(), irregular_sheet_at("far", {10, 5, 0}, 9));
    set.set_scene(more);
    steps(of, set, 20), steps(of, alone, 20);
    std::vector<Vec3> now = set.velocities();
    now.erase(now.begin(), now.begin() + kParticles);
    EXPECT_LT(farthest(now, alone.velocities(), now.size()), 1e-6) << "particles may be projected in another order";
  }
}

/// A particle above the top of an object that keeps 10 mm.
Scene particle_above(const Shape& shape, double height, const Vec3& velocity) {
  Scene scene = scene_of({particle({0, 0.2 + height, 0}, velocity)}, {0, 0, 0}, 0.01, 5);
  scene.environment = {object_at("object", shape, {0, 0, 0})};
  return scene;
}

class PressedOnto : public testing::TestWithParam<Shape> {};

TEST_P(PressedOnto, TheOverlapStaysWhatItWas) {
  const Scene scene = particle_above(GetParam(), 0.004, {0, 0, 0});
  Simulation set(scene, {.threads = 1}), alone(scene, {.threads = 1});
  for (int step = 0; step < 5; ++step) set.step(), alone.step();
  EXPECT_NEAR(set.positions()[0][1], 0.204, 1e-6) << "keeps its overlap of 6 mm";
  Scene more = scene;
  more.bodies.push_back(particle({0, 0.2 + 0.003, 5}));
  more.bodies.back().name = "another";
  more.environment.push_back(object_at("second", GetParam(), {0, 0, 5}));
  for (int round = 0; round < 4; ++round) {
    set.set_scene(round % 2 == 0 ? more : scene);
    for (int step = 0; step < 5; ++step) {
      set.step(), alone.step();
      EXPECT_EQ(set.positions()[0], alone.positions()[0]);
      EXPECT_EQ(set.velocities()[0], alone.velocities()[0]);
    }
    if (round == 0) {
      EXPECT_NEAR(set.positions()[1][1], 0.203, 1e-6) << "the new one keeps its own";
    }
  }
}

TEST_P(PressedOnto, AParticleThatFellStaysAtTheThickness) {
  const Scene scene = particle_above(GetParam(), 0.02, {0, -0.5, 0});
  Simulation set(scene, {.threads = 1}), alone(scene, {.threads = 1});
  for (Simulation* one : {&set, &alone})
    for (int step = 0; step < 10; ++step) one->step();
  Scene more = scene;
  more.bodies.push_back(particle({0, 9, 0}));
  more.bodies.back().name = "another";
  set.set_scene(more);
  for (int step = 0; step < 20; ++step) set.step(), alone.step();
  EXPECT_EQ(set.positions()[0], alone.positions()[0]);
  EXPECT_GT(set.positions()[0][1], 0.2099) << "at the thickness";
}

TEST_P(PressedOnto, AnotherThicknessThrowsNothing) {
  Scene scene = particle_above(GetParam(), 0.011, {0, 0, 0});
  Simulation simulation = after(scene, 0.1);
  scene.environment[0].thickness = 0.02;
  simulation.set_scene(scene);
  for (int step = 0; step < 10; ++step) simulation.step();
  EXPECT_LT(length(simulation.velocities()[0]), 1e-9);
  EXPECT_NEAR(simulation.positions()[0][1], 0.211, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Shapes, PressedOnto,
                         testing::Values(Shape(SphereShape{0.2, 3}), Shape(SphereShape{0.2, std::nullopt}),
                                         Shape(BoxShape{{1, 0.4, 1}, std::array{3, 2, 3}}),
                                         Shape(BoxShape{{1, 0.4, 1}, std::nullopt})));

TEST(SetSceneWithOther, MassesAndStiffnessThrowsNothing) {
  in_each_way(in_contact(), [](const Replaced& of) {
    Simulation set(of.scene, {.threads = 1}), alone(of.scene, {.threads = 1});
    steps(of, set, 60), steps(of, alone, 60);
    Scene other = set.scene();
    for (BodySpec& body : other.bodies) {
      body.mass = 0.102;
      body.constraints[0].compliance = 1.02e-5;
    }
    set.set_scene(other);
    double usual = 0, most = 0;  // m/s
    for (int step = 0; step < 10; ++step) {
      steps(of, set, 1), steps(of, alone, 1);
      for (const Vec3& v : alone.velocities()) usual = std::max(usual, length(v));
      for (const Vec3& v : set.velocities()) most = std::max(most, length(v));
    }
    EXPECT_LT(most, 1.1 * usual + 0.02);
  });
}

TEST(SetSceneWithOther, PrecisionGoesOnFromTheSameState) {
  for (const Precision from : {Precision::Double, Precision::Float})
    for (const Replaced& of : in_contact()) {
      SCOPED_TRACE(of.name + (from == Precision::Float ? " from float" : " from double"));
      Scene scene = of.scene;
      scene.solver.precision = from;
      Simulation set(scene, {.threads = 1}), alone(scene, {.threads = 1});
      steps(of, set, 40), steps(of, alone, 40);
      scene = set.scene();
      scene.solver.precision = from == Precision::Float ? Precision::Double : Precision::Float;
      set.set_scene(scene);
      EXPECT_LT(farthest(set.positions(), alone.positions(), kParticles), from == Precision::Float ? 1e-30 : 1e-12);
      steps(of, set, 3), steps(of, alone, 3);
      EXPECT_LT(farthest(set.positions(), alone.positions(), kParticles), 1e-4);
      set.count_crossings();
      EXPECT_EQ(set.measure().crossings, 0);
    }
}

TEST(SetSceneWithOther, PinsLetsGoWithoutAThrow) {
  for (const Shape& shape : {Shape(SphereShape{0.2, 3}), Shape(SphereShape{0.2, std::nullopt})}) {
    Scene scene = particle_above(shape, 0.004, {0, 0, 0});
    scene.bodies[0].pins = {ListPin{{0}}};
    Simulation simulation = after(scene, 0.1);
    scene.bodies[0].pins.clear();
    simulation.set_scene(scene);
    for (int step = 0; step < 10; ++step) simulation.step();
    EXPECT_LT(length(simulation.velocities()[0]), 1e-9);
    EXPECT_NEAR(simulation.positions()[0][1], 0.204, 1e-6);
  }
}

TEST(SetSceneWithMore, RefusesABodyThroughAnotherOneWhereItIsNow) {
  Scene scene = scene_of({irregular_sheet_at("sheet", {0, 0, 0}, 5)}, kEarth, 0.01, 5);
  scene.self_collision.emplace().thickness = 0.008;
  Simulation simulation = after(scene, 0.4), alone = after(scene, 0.4);
  const double fallen = simulation.positions()[40][1];
  ASSERT_LT(fallen, -0.5);
  BodySpec more = irregular_sheet_at("through it", {0.2, fallen, 0}, 6);
  more.transform.axis = {0, 0, 1}, more.transform.degrees = 90;
  scene.bodies.push_back(more);
  EXPECT_NE(refusal([&] { simulation.set_scene(scene); }).find("crossings"), std::string::npos);
  simulation.step(), alone.step();
  EXPECT_EQ(simulation.state_hash(), alone.state_hash()) << "nothing has changed";
  scene.bodies[1].transform.translate = {0.2, fallen - 0.4, 0};
  simulation.set_scene(scene);
  for (int step = 0; step < 5; ++step) simulation.step();
  EXPECT_EQ(simulation.measure().crossings, 0);
}

TEST(SetSceneWithMore, RefusesAnObjectInABodyThatRests) {
  for (const char* method : {"pbd", "desbrun"})
    for (const Shape& shape : {kBall, kExactBall, kBlock}) {
      Scene scene = scene_of({irregular_sheet_at("sheet", {0.03, 0.3, -0.02}, 5)}, kEarth, 0.01, 5);
      scene.solver.type = method;
      scene.environment = {object_at("floor", PlaneShape{}, {0, 0, 0})};
      Simulation simulation = after(scene, 1), alone = after(scene, 1);
      Scene more = scene;
      more.environment.push_back(object_at("in it", shape, {0.03, 0.05, 0}));
      EXPECT_NE(refusal([&] { simulation.set_scene(more); }).find("deep inside an object"), std::string::npos);
      more = scene, more.environment[0].transform.translate = {0, 0.05, 0};
      EXPECT_NE(refusal([&] { simulation.set_scene(more); }).find("deep inside an object"), std::string::npos);
      simulation.step(), alone.step();
      EXPECT_EQ(simulation.state_hash(), alone.state_hash()) << "nothing has changed";
      more = scene, more.environment.push_back(object_at("above it", shape, {0.03, 0.8, 0}));
      simulation.set_scene(more);
      for (int step = 0; step < 10; ++step) simulation.step();
      for (const Vec3& v : simulation.velocities()) ASSERT_LT(length(v), 0.01);
    }
}

TEST(SetSceneWithMore, WakesASceneThatSleeps) {
  const Replaced of = asleep();
  Simulation simulation(of.scene, {.threads = 1});
  steps(of, simulation, 80);
  ASSERT_GT(simulation.solver().sleep()->particles, 0);
  simulation.set_scene(simulation.scene());
  EXPECT_GT(simulation.solver().sleep()->particles, 0) << "the same scene sleeps on";
  Scene more = of.scene;
  more.bodies.push_back(irregular_sheet_at("falls", {0.1, 0.5, 0}, 9));
  simulation.set_scene(more);
  EXPECT_EQ(simulation.solver().sleep()->particles, 0);
  steps(of, simulation, 100);
  EXPECT_LT(simulation.positions().back()[1], 0.02) << "it has fallen";
}

}  // namespace
}  // namespace malha
