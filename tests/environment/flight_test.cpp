// SPDX-License-Identifier: Apache-2.0
// What the environment costs less: a step in which nothing can come near it is visits alone, and a particle that comes
// again as it came keeps its contact. Nobody can tell either from a step that looks at everything.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/report/launches.h"
#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "malha/simulation.h"
#include "tests/environment/contact_bench.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/on_host.h"
#include "tests/scene_builders.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Far off, and it moves: with it in a scene every step looks.
EnvironmentSpec moving_far_off() {
  EnvironmentSpec box = obstacle("far", BoxShape{});
  box.transform.translate = {0, -1000, 0};
  Keyframe last;
  last.time = 10, last.translate = {0, 0, 1};
  box.motion = {Keyframe{}, last};
  return box;
}

/// An irregular sheet, a soft ball, a held cloth and loose particles over a ball, a slope that is seen from above, and
/// a wall that has two sides.
Scene flying_bodies(const TemporaryFolder& folder, Precision precision, int iterations) {
  Scene scene;
  scene.file = "test.json", scene.name = "test", scene.gravity = {0, -9.81, 0};
  scene.solver.precision = precision, scene.solver.iterations = iterations, scene.solver.levels = 0;
  BodySpec sheet = body("sheet", MeshFile{folder.write("sheet.obj", irregular_obj(0.6, 0.5, 23, 19, 0.3, 7))},
                        {constraint("distance"), constraint("bending")});
  sheet.transform.translate = {-0.3, 1.2, -0.2}, sheet.velocity = {1, 2, 0.5}, sheet.spin = {1, 2, 3};
  BodySpec soft = body("soft", TetBoxShape{{0.3, 0.3, 0.3}, {4, 4, 4}}, {constraint("distance"), constraint("volume")});
  soft.transform.translate = {2, 1.5, 0}, soft.velocity = {-3, 1, 0};
  BodySpec held = body("held", GridShape{{0.5, 0.5}, {9, 9}}, {with_compliance("distance", 1e-4)});
  held.transform.translate = {4, 2, 0}, held.pins = {RowPin{}};
  BodySpec loose = body("loose", LatticeShape{{-1, 2, -1}, {-0.5, 3, 1}, {3, 7, 11}});
  scene.bodies = {sheet, soft, held, loose};
  EnvironmentSpec ball = obstacle("ball", SphereShape{0.4, 3});
  ball.friction = 0.4, ball.restitution = 0.5;
  EnvironmentSpec slope = obstacle("slope", GridShape{{9, 4}, {6, 5}}, Sides::OneSided);
  slope.transform.axis = {0, 0, 1}, slope.transform.degrees = 10, slope.transform.translate = {-4, -1.5, -2};
  EnvironmentSpec wall = obstacle("wall", GridShape{{3, 3}, {3, 3}}, Sides::TwoSided);
  wall.transform.axis = {0, 0, 1}, wall.transform.degrees = 90, wall.transform.translate = {1, -2, -1};
  scene.environment = {ball, slope, wall};
  return scene;
}

double seconds_of(const Solver& solver, Pass pass) { return solver.pass_seconds()[static_cast<int>(pass)]; }

struct FlightCase {
  Precision precision;
  int iterations, threads;
};
class Flight : public testing::TestWithParam<FlightCase> {};

TEST_P(Flight, HasTheBitsOfStepsThatLook) {
  const auto [precision, iterations, threads] = GetParam();
  const TemporaryFolder folder;
  Scene scene = flying_bodies(folder, precision, iterations);
  const Model model = build_model(scene);
  scene.environment.push_back(moving_far_off());
  const Model looked_at = build_model(scene);
  const auto contact_free_steps = make_solver(model, threads), looks = make_solver(looked_at, 1);
  ASSERT_TRUE(contact_free_steps->facts().contact_free_steps);
  ASSERT_FALSE(looks->facts().contact_free_steps);
  int touching = 0;
  for (int step = 0; step < 90; ++step) {
    contact_free_steps->step(), looks->step();
    ASSERT_EQ(contact_free_steps->state_hash(), looks->state_hash()) << "after step " << step;
    touching = std::max(touching, contact_free_steps->measure().contacts);
    ASSERT_EQ(contact_free_steps->measure().contacts, looks->measure().contacts) << "after step " << step;
  }
  if (scenes_run_on_host()) {
    EXPECT_GT(seconds_of(*contact_free_steps, Pass::FusedSolve), 0) << "some steps were flights";
    EXPECT_GT(seconds_of(*contact_free_steps, Pass::State), 0) << "some were not";
  }
  EXPECT_EQ(seconds_of(*looks, Pass::FusedSolve), 0);
  EXPECT_GT(touching, 20);
}

INSTANTIATE_TEST_SUITE_P(Precisions, Flight,
                         testing::Values(FlightCase{Precision::Float, 1, 1}, FlightCase{Precision::Float, 3, 3},
                                         FlightCase{Precision::Double, 1, 2}, FlightCase{Precision::Double, 2, 1}),
                         [](const auto& info) {
                           return (info.param.precision == Precision::Float ? "Float" : "Double") +
                                  std::to_string(info.param.iterations) + "On" + std::to_string(info.param.threads);
                         });

/// The same environment, of which nothing rests: it moves nowhere.
void let_move(Scene& scene) {
  for (EnvironmentSpec& object : scene.environment) {
    Keyframe last;
    last.time = 10;
    object.motion = {Keyframe{}, last};
  }
}

class Staying : public testing::TestWithParam<Precision> {};

/// A cloth, a soft ball and loose particles come to rest on a floor with two sides, against a wall and on a ball.
TEST_P(Staying, HasTheBitsOfStepsThatLook) {
  const TemporaryFolder folder;
  Scene scene = flying_bodies(folder, GetParam(), 2);
  scene.bodies[0].transform.translate = {-2, 0.1, -0.2}, scene.bodies[0].velocity = scene.bodies[0].spin = {0, 0, 0};
  scene.bodies[1].transform.translate = {0.8, 0.2, 0.3}, scene.bodies[1].velocity = {0.5, 0, 0};
  scene.bodies[2].transform.translate = {0.2, 0.6, 0.1}, scene.bodies[2].pins.clear();
  scene.bodies[3].shape = LatticeShape{{-2, 0.3, -1}, {0.9, 0.5, 1}, {7, 2, 5}};
  scene.environment[1] = obstacle("floor", GridShape{{9, 9}, {6, 5}}, Sides::TwoSided);
  scene.environment[1].transform.translate = {-4, -0.02, -4};
  for (EnvironmentSpec& object : scene.environment) object.friction = 0.6;
  const Model model = build_model(scene);
  let_move(scene);
  const Model moving = build_model(scene);
  const auto rests = make_solver(model, 2), looks = make_solver(moving, 1);
  for (int step = 0; step < 240; ++step) {
    rests->step(), looks->step();
    ASSERT_EQ(rests->state_hash(), looks->state_hash()) << "after step " << step;
  }
  EXPECT_EQ(rests->measure().contacts, looks->measure().contacts);
  EXPECT_GT(rests->measure().contacts, 50);
  EXPECT_EQ(rests->measure().penetration_max, looks->measure().penetration_max);
}

INSTANTIATE_TEST_SUITE_P(Precisions, Staying, testing::Values(Precision::Float, Precision::Double));

TEST(Contact, OfWhatComesAgainAsItCameStays) {
  EnvironmentSpec floor = obstacle("floor", GridShape{{2, 2}, {3, 3}}, Sides::OneSided);
  floor.transform.translate = {-1, 0, -1}, floor.friction = 0.5;
  ContactBench<Serial, float> bench({}, floor, {{0.1, 0.005, 0.2}, {-0.3, 0.2, 0.1}}, {{0, 0, 0}, {0, 0, 0}});
  const auto fall = [&](int substeps) {
    for (int s = 0; s < substeps; ++s) bench.substep(1.0 / 600, {0, -9.81, 0}, 2);
  };
  // A look finds its triangle, which is one of the floor's.
  const auto is_looked_at = [&](int i) {
    bench.near(i).seen.triangle = -7;
    fall(1);
    return bench.near(i).seen.triangle != -7;
  };
  fall(10);
  EXPECT_FALSE(is_looked_at(0)) << "it lies";
  fall(1200);
  EXPECT_FALSE(is_looked_at(1)) << "it has come to rest";
  bench.push(0, {0.3, 0, 0});
  fall(1);
  EXPECT_TRUE(is_looked_at(0)) << "it slides";
  fall(300);  // mu g takes 0.3 m/s in 0.06 s and 9 mm
  EXPECT_FALSE(is_looked_at(0)) << "it lies again";
  EXPECT_NEAR(bench.x(0).x, 0.1 + 0.3 * 0.3 / (2 * 0.5 * 9.81), 3e-4);
  EXPECT_NEAR(bench.x(0).y, 0.005, 1e-6);
}

/// A particle at the origin, on a link to a pin at x = 3, across a wall at x = 0.5; the link is as long as it is, or
/// `rest_scale` times that.
Scene linked_across_a_wall(double rest_scale, Precision precision) {
  BodySpec link = body("link", ChainShape{{0, 0, 0}, {3, 0, 0}, 1}, {constraint("distance", rest_scale)});
  link.pins = {BoxPin{{2.9, -1, -1}, {3.1, 1, 1}}};
  EnvironmentSpec wall = obstacle("wall", GridShape{{2, 2}, {3, 3}}, Sides::TwoSided);
  wall.transform.axis = {0, 0, 1}, wall.transform.degrees = 90, wall.transform.translate = {0.5, -1, -1};
  Scene scene = scene_of({link}, {wall});
  scene.solver.precision = precision;
  return scene;
}

class Jerked : public testing::TestWithParam<Precision> {};

TEST_P(Jerked, FartherThanItsSpeedToldAParticleStopsAtTheWall) {
  const Model calm = build_model(linked_across_a_wall(1, GetParam()));
  const Model taut = build_model(linked_across_a_wall(0.01, GetParam()));
  const auto first = make_solver(calm, 1), then = make_solver(taut, 1);
  first->step();
  then->restore(first->save());  // half a metre from the wall, as is known, and at rest
  const std::vector<Vec3> before = then->positions();
  ASSERT_NEAR(before[0][0], 0, 1e-6);
  then->step();
  if (scenes_run_on_host()) {
    EXPECT_GT(seconds_of(*then, Pass::FusedSolve), 0) << "it began as a flight";
  }
  for (int step = 0; step < 5; ++step) {
    const Vec3 x = then->positions()[0];
    EXPECT_LE(x[0], 0.5 + 1e-6) << "step " << step;
    EXPECT_NEAR(x[0], 0.5 - 0.005, 1e-5) << "a thickness before the wall, step " << step;
    then->step();
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, Jerked, testing::Values(Precision::Float, Precision::Double));

TEST(Flights, AreNotForScenesThatAskForMore) {
  const TemporaryFolder folder;
  const Scene scene = flying_bodies(folder, Precision::Float, 1);
  const auto contact_free_steps = [](Scene changed) {
    return make_solver(build_model(changed), 1)->facts().contact_free_steps;
  };
  ASSERT_TRUE(contact_free_steps(scene));
  Scene bare = scene, damped = scene, windy = scene, edges = scene, self = scene;
  bare.environment.clear();
  damped.bodies[0].damping = 0.1;
  windy.wind.emplace(), windy.wind->drag = 0.001;
  edges.environment[0].edges = true;
  self.self_collision.emplace(), self.self_collision->thickness = 1e-3;
  for (const Scene& other : {bare, damped, windy, edges, self}) EXPECT_FALSE(contact_free_steps(other));
}

TEST(Flights, LaunchWhatThePlanSays) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  const TemporaryFolder folder;
  const Scene scene = flying_bodies(folder, Precision::Float, 2);
  Simulation simulation(scene, {.threads = 1});
  simulation.step();  // the first one looks: nothing is known yet
  const LaunchTrace trace;
  simulation.step();
  std::int64_t launched = 0;
  for (const Launches& of : trace.list()) launched += of.launches;
  const std::string text = plan(simulation);
  const std::string said = "\n  while nothing comes near the environment: " + std::to_string(launched) + "\n";
  EXPECT_NE(text.find(said), std::string::npos) << said << " is not in\n" << text;
}

}  // namespace
}  // namespace malha
