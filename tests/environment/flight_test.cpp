// SPDX-License-Identifier: Apache-2.0
// Steps that save the cost of contact detection: a step in which nothing can come near the environment is one fused
// patch solve, and a particle that returns with the same prediction keeps its contact. Both have the bits of steps that
// detect every contact.
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

/// A moving object far away: in a scene with it every step detects contacts.
EnvironmentSpec moving_object_far_away() {
  EnvironmentSpec box = obstacle("far", BoxShape{});
  box.transform.translate = {0, -1000, 0};
  Keyframe last;
  last.time = 10, last.translate = {0, 0, 1};
  box.motion = {Keyframe{}, last};
  return box;
}

/// An irregular sheet, a soft ball, a pinned cloth and loose particles above a ball, a one-sided slope, and a two-sided
/// wall.
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

struct ContactFreeCase {
  Precision precision;
  int iterations, threads;
};
class ContactFreeStep : public testing::TestWithParam<ContactFreeCase> {};

TEST_P(ContactFreeStep, HasTheBitsOfAStepThatDetectsContacts) {
  const auto [precision, iterations, threads] = GetParam();
  const TemporaryFolder folder;
  Scene scene = flying_bodies(folder, precision, iterations);
  const Model model = build_model(scene);
  scene.environment.push_back(moving_object_far_away());
  const Model with_moving_object = build_model(scene);
  const auto contact_free_steps = make_solver(model, threads), detects = make_solver(with_moving_object, 1);
  ASSERT_TRUE(contact_free_steps->step_plan().skips_contacts);
  ASSERT_FALSE(detects->step_plan().skips_contacts);
  int touching = 0;
  for (int step = 0; step < 90; ++step) {
    contact_free_steps->step(), detects->step();
    ASSERT_EQ(contact_free_steps->state_hash(), detects->state_hash()) << "after step " << step;
    touching = std::max(touching, contact_free_steps->measure().contacts);
    ASSERT_EQ(contact_free_steps->measure().contacts, detects->measure().contacts) << "after step " << step;
  }
  if (scenes_run_on_host()) {
    EXPECT_GT(seconds_of(*contact_free_steps, Pass::FusedSolve), 0) << "some steps detected no contacts";
    EXPECT_GT(seconds_of(*contact_free_steps, Pass::State), 0) << "some did";
  }
  EXPECT_EQ(seconds_of(*detects, Pass::FusedSolve), 0);
  EXPECT_GT(touching, 20);
}

INSTANTIATE_TEST_SUITE_P(Precisions, ContactFreeStep,
                         testing::Values(ContactFreeCase{Precision::Float, 1, 1},
                                         ContactFreeCase{Precision::Float, 3, 3},
                                         ContactFreeCase{Precision::Double, 1, 2},
                                         ContactFreeCase{Precision::Double, 2, 1}),
                         [](const auto& info) {
                           return (info.param.precision == Precision::Float ? "Float" : "Double") +
                                  std::to_string(info.param.iterations) + "On" + std::to_string(info.param.threads);
                         });

/// Gives all objects a motion that leaves them where they are, so that none counts as resting.
void let_move(Scene& scene) {
  for (EnvironmentSpec& object : scene.environment) {
    Keyframe last;
    last.time = 10;
    object.motion = {Keyframe{}, last};
  }
}

class ContactsAtRest : public testing::TestWithParam<Precision> {};

/// A cloth, a soft ball and loose particles come to rest on a two-sided floor, against a wall and on a ball.
TEST_P(ContactsAtRest, HaveTheBitsOfContactsDetectedAnew) {
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
  const auto rests = make_solver(model, 2), detects = make_solver(moving, 1);
  for (int step = 0; step < 240; ++step) {
    rests->step(), detects->step();
    ASSERT_EQ(rests->state_hash(), detects->state_hash()) << "after step " << step;
  }
  EXPECT_EQ(rests->measure().contacts, detects->measure().contacts);
  EXPECT_GT(rests->measure().contacts, 50);
  EXPECT_EQ(rests->measure().penetration_max, detects->measure().penetration_max);
}

INSTANTIATE_TEST_SUITE_P(Precisions, ContactsAtRest, testing::Values(Precision::Float, Precision::Double));

TEST(Contact, IsReusedWhereAParticleReturnsWithTheSamePrediction) {
  EnvironmentSpec floor = obstacle("floor", GridShape{{2, 2}, {3, 3}}, Sides::OneSided);
  floor.transform.translate = {-1, 0, -1}, floor.friction = 0.5;
  ContactBench<Serial, float> bench({}, floor, {{0.1, 0.005, 0.2}, {-0.3, 0.2, 0.1}}, {{0, 0, 0}, {0, 0, 0}});
  const auto fall = [&](int substeps) {
    for (int s = 0; s < substeps; ++s) bench.substep(1.0 / 600, {0, -9.81, 0}, 2);
  };
  // A query finds a triangle of the floor, and replaces this number.
  const auto is_queried = [&](int i) {
    bench.near(i).record.triangle = -7;
    fall(1);
    return bench.near(i).record.triangle != -7;
  };
  fall(10);
  EXPECT_FALSE(is_queried(0)) << "it lies";
  fall(1200);
  EXPECT_FALSE(is_queried(1)) << "it has come to rest";
  bench.push(0, {0.3, 0, 0});
  fall(1);
  EXPECT_TRUE(is_queried(0)) << "it slides";
  fall(300);  // mu g takes 0.3 m/s in 0.06 s and 9 mm
  EXPECT_FALSE(is_queried(0)) << "it lies again";
  EXPECT_NEAR(bench.x(0).x, 0.1 + 0.3 * 0.3 / (2 * 0.5 * 9.81), 3e-4);
  EXPECT_NEAR(bench.x(0).y, 0.005, 1e-6);
}

/// A particle at the origin, linked to a pin at x = 3 across a wall at x = 0.5; the rest length is `rest_scale` times
/// the link's length.
Scene linked_across_a_wall(double rest_scale, Precision precision) {
  BodySpec link = body("link", ChainShape{{0, 0, 0}, {3, 0, 0}, 1}, {constraint("distance", rest_scale)});
  link.pins = {BoxPin{{2.9, -1, -1}, {3.1, 1, 1}}};
  EnvironmentSpec wall = obstacle("wall", GridShape{{2, 2}, {3, 3}}, Sides::TwoSided);
  wall.transform.axis = {0, 0, 1}, wall.transform.degrees = 90, wall.transform.translate = {0.5, -1, -1};
  Scene scene = scene_of({link}, {wall});
  scene.solver.precision = precision;
  return scene;
}

class PulledByALink : public testing::TestWithParam<Precision> {};

TEST_P(PulledByALink, FartherThanItsVelocityPredictsAParticleStopsAtTheWall) {
  const Model calm = build_model(linked_across_a_wall(1, GetParam()));
  const Model taut = build_model(linked_across_a_wall(0.01, GetParam()));
  const auto first = make_solver(calm, 1), then = make_solver(taut, 1);
  first->step();
  then->restore(first->save());  // It is known to be half a metre from the wall, and at rest.
  const std::vector<Vec3> before = then->positions();
  ASSERT_NEAR(before[0][0], 0, 1e-6);
  then->step();
  if (scenes_run_on_host()) {
    EXPECT_GT(seconds_of(*then, Pass::FusedSolve), 0) << "it began without contact detection";
  }
  for (int step = 0; step < 5; ++step) {
    const Vec3 x = then->positions()[0];
    EXPECT_LE(x[0], 0.5 + 1e-6) << "step " << step;
    EXPECT_NEAR(x[0], 0.5 - 0.005, 1e-5) << "a thickness before the wall, step " << step;
    then->step();
  }
}

TEST_P(PulledByALink, ItStopsAtAThinSolidOfEitherKindToo) {
  // Beyond a solid that is thinner than the way of the particle no later contact would know where it came from.
  for (const BoxShape& box : {BoxShape{{0.01, 2, 2}, {{1, 2, 2}}}, BoxShape{{0.01, 2, 2}, std::nullopt}}) {
    const auto scene = [&](double rest_scale) {
      Scene linked = linked_across_a_wall(rest_scale, GetParam());
      linked.environment[0] = obstacle("wall", box);
      linked.environment[0].transform.translate = {0.505, 0, 0};
      return linked;
    };
    const Model calm = build_model(scene(1)), taut = build_model(scene(0.01));
    const auto first = make_solver(calm, 1), then = make_solver(taut, 1);
    first->step();
    then->restore(first->save());
    for (int step = 0; step < 5; ++step) {
      then->step();
      EXPECT_NEAR(then->positions()[0][0], 0.5 - 0.005, 1e-5) << "a thickness before the wall, step " << step;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, PulledByALink, testing::Values(Precision::Float, Precision::Double));

TEST(ContactFreeSteps, AreNotTakenWhereTheSceneHasPassesInBetween) {
  const TemporaryFolder folder;
  const Scene scene = flying_bodies(folder, Precision::Float, 1);
  const auto contact_free_steps = [](Scene changed) {
    return make_solver(build_model(changed), 1)->step_plan().skips_contacts;
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

TEST(ContactFreeSteps, LaunchWhatThePlanSays) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  const TemporaryFolder folder;
  const Scene scene = flying_bodies(folder, Precision::Float, 2);
  Simulation simulation(scene, {.threads = 1});
  simulation.step();  // the first step detects contacts, because no clearance is known yet
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
