// SPDX-License-Identifier: Apache-2.0
// Bodies that intersect at the start, as real models do: if the scene allows it, they collide after they have
// separated.
#include <gtest/gtest.h>

#include "host/measure/solver_stats.h"
#include "host/model/self_surface.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// An upright sheet, half of it above a level one, is moved down out of that and up against it again.
Scene drawn_out_and_back(const TemporaryFolder& folder, Precision precision) {
  Random random(5);
  BodySpec level, upright;
  level.name = "level", upright.name = "upright";
  level.shape = MeshFile{folder.write("level.obj", irregular_sheet(1, 1, 9, 9, random))};
  upright.shape = MeshFile{folder.write("upright.obj", irregular_sheet(0.6, 0.4, 8, 6, random))};
  level.mass = 0.2, upright.mass = 0.1;
  level.constraints = upright.constraints = {stiff("distance", {"edges"}), stiff("bending", {}, 0.1)};
  upright.transform.axis = {1, 0, 0}, upright.transform.degrees = 90;
  upright.transform.translate = {0.21, 0.2, 0.53};
  ListPin all_but_one;  // a body needs a movable particle
  for (int i = 1; i < 9 * 7; ++i) all_but_one.particles.push_back(i);
  Pin held = all_but_one;
  Keyframe start, below, above;
  below.time = 0.3, below.translate = {0, -0.3, 0};
  above.time = 0.8, above.translate = {0, 0.1, 0};
  held.motion = {start, below, above};
  upright.pins = {held};
  Scene scene = scene_of({level, upright}, {}, 1.0 / 60, 10, precision);
  scene.self_collision = SelfCollision{0.01, 0.2, {}};
  return scene;
}

// If the scene allows it, bodies that intersect at the start move out of each other, and never in again.
TEST(InitialIntersections, AreIgnoredUntilTheBodiesHaveSeparated) {
  const TemporaryFolder folder;
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene scene = drawn_out_and_back(folder, precision);
    EXPECT_TRUE(has(refusal([&] { Simulation(scene, {.threads = 1}); }), "or \"crossing_at_start\": \"ignore\""));
    scene.self_collision->ignores_crossings = true;
    Simulation simulation(scene, {.threads = 1});
    const std::int64_t at_start = simulation.measure().crossings;
    ASSERT_GT(at_start, 5);
    EXPECT_EQ(simulation.solver().facts().self->crossings, at_start);
    EXPECT_TRUE(has(simulation.report("finished"), "these primitives collide once they have separated"));
    int parted = -1;
    for (int step = 0; step < 48; ++step) {
      simulation.step();
      const std::int64_t now = simulation.measure().crossings;
      if (now == 0 && parted < 0) parted = step;
      if (parted >= 0) {
        ASSERT_EQ(now, 0) << "step " << step << ", parted in step " << parted;
      }
    }
    EXPECT_GT(parted, 5);
    EXPECT_LT(parted, 20);
    double height = 0;
    for (int i = 0; i < 100; ++i) height += simulation.positions()[i][1] / 100;
    EXPECT_GT(height, 0.05) << "the sheet that was drawn out lifts the other";
  }
}

// Two equal balls side by side intersect with edges exactly on edges: no edge goes through the inside of a triangle
// until they move.
TEST(InitialIntersections, AreFoundWhereEdgesCutEdges) {
  std::vector<BodySpec> balls;
  for (const int side : {-1, 1}) {
    BodySpec ball;
    ball.name = side < 0 ? "left" : "right";
    ball.shape = SphereShape{0.25, 2};
    ball.mass = 0.5;
    ball.transform.translate = {0.2 * side, 0, 0};
    ball.velocity = {0.5 * side, 0, 0};
    ball.constraints = {stiff("distance", {"edges"})};
    balls.push_back(ball);
  }
  Scene scene = scene_of(balls, {}, 1.0 / 60, 10, Precision::Float);
  scene.self_collision = SelfCollision{0.005, 0, {}};
  EXPECT_TRUE(has(refusal([&] { Simulation(scene, {.threads = 1}); }), "bodies that cross or touch at the start"));
  scene.self_collision->ignores_crossings = true;
  Simulation simulation(scene, {.threads = 1});
  EXPECT_GT(simulation.solver().facts().self->crossings, 10);
  std::int64_t most = 0;
  for (int step = 0; step < 60; ++step) simulation.step(), most = std::max(most, simulation.measure().crossings);
  EXPECT_GT(most, 10);
  EXPECT_EQ(simulation.measure().crossings, 0);
}

BodySpec sheet_at(const std::string& name, const Vec3& at) {
  BodySpec body;
  body.name = name, body.shape = GridShape{{1, 1}, {5, 5}}, body.mass = 0.2;
  body.transform.translate = at;
  body.constraints = {stiff("distance", {"edges"})};
  return body;
}

// Such bodies have no side on which they could be kept.
TEST(InitialIntersections, AreFoundWhereBodiesTouchInOnePlane) {
  const auto scene = [](const Vec3& at, Precision precision) {
    Scene both = scene_of({sheet_at("one", {0, 1, 0}), sheet_at("other", at)}, {}, 1.0 / 60, 10, precision);
    both.self_collision = SelfCollision{0.005, 0, {}};
    return both;
  };
  const auto refused = [&](const Vec3& at, Precision precision) {
    return has(refusal([&] { Simulation(scene(at, precision), {.threads = 1}); }), "cross or touch at the start");
  };
  EXPECT_TRUE(refused({0.33, 1, 0.27}, Precision::Double)) << "they overlap";
  EXPECT_TRUE(refused({0, 1, 0}, Precision::Double)) << "they are one";
  EXPECT_TRUE(refused({0.1, 1, 1}, Precision::Double)) << "their rims touch";
  EXPECT_TRUE(refused({0.33, 1 + 1e-9, 0.27}, Precision::Float)) << "one number in float";
  EXPECT_NO_THROW(Simulation(scene({0.33, 1 + 1e-9, 0.27}, Precision::Double), {.threads = 1}));
  EXPECT_NO_THROW(Simulation(scene({0.1, 1, 1.01}, Precision::Double), {.threads = 1})) << "side by side";
}

// An upright sheet intersects two level ones: these still do not go through each other, also near the upright one.
TEST(InitialIntersections, WithOneBodyDoNotExemptTheOthers) {
  std::vector<BodySpec> bodies{sheet_at("lower", {0, 0, 0}), sheet_at("upright", {0.02, -0.47, 0.43}),
                               sheet_at("upper", {0.03, 0.1, 0.04})};
  bodies[1].transform.axis = {1, 0, 0}, bodies[1].transform.degrees = -87;
  ListPin all_but_one;
  for (int i = 1; i < 36; ++i) all_but_one.particles.push_back(i);
  for (int b = 0; b < 2; ++b) bodies[b].pins = {all_but_one};
  Scene scene = scene_of(bodies, kEarth, 1.0 / 60, 10, Precision::Float);
  scene.self_collision = SelfCollision{0.01, 0.2, {}};
  scene.self_collision->ignores_crossings = true;
  Simulation simulation(scene, {.threads = 1});
  const SelfSurface surface = self_surface(simulation.model());
  std::vector<Vec3> x(simulation.model().count());
  for (int step = 0; step < 40; ++step) {
    simulation.step();
    const std::vector<Vec3> now = simulation.positions();
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = now[simulation.model().user_index[i]];
    int with_upright = 0, beside = 0;
    for (const auto& [edge, triangle] : crossings_and_touches(surface, x))
      ++(surface.body[edge[0]] == 1 || surface.body[triangle[0]] == 1 ? with_upright : beside);
    ASSERT_EQ(beside, 0) << "step " << step;
    ASSERT_GT(with_upright, 0) << "step " << step;
  }
  EXPECT_GT(simulation.measure().self_contacts, 0) << "the upper one lies on the lower one";
}

INSTANTIATE_TEST_SUITE_P(InitialIntersections, SameBits,
                         testing::Values(SameBitsScene{"Ignored",
                                                       [](const TemporaryFolder& folder) {
                                                         Scene scene = drawn_out_and_back(folder, Precision::Float);
                                                         scene.self_collision->ignores_crossings = true;
                                                         return scene;
                                                       },
                                                       20,
                                                       {0, 3, 6, 9, 12, 15, 18}}),
                         name_of_scene);

}  // namespace
}  // namespace malha
