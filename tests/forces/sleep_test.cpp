// SPDX-License-Identifier: Apache-2.0
// Sleep: resting bodies keep their positions bit by bit, cost nothing, and wake when something comes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "tests/on_host.h"
#include "tests/same_bits.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A sheet that falls onto the ground from 2 cm, and a hammer that comes down on it at 3 s; far away a wheel turns.
Scene resting_sheet(const std::string& solver = "pbd", Precision precision = Precision::Float) {
  BodySpec sheet;
  sheet.name = "sheet";
  sheet.shape = GridShape{{1, 1}, {8, 8}};
  sheet.transform.translate = {-0.5, 0.02, -0.5};
  sheet.mass = 0.2;
  sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 4, precision);
  scene.solver.type = solver;
  scene.solver.desbrun.spring_constant = 500;
  EnvironmentSpec ground = obstacle("ground", GridShape{{4, 4}, {1, 1}}, Sides::OneSided);
  ground.transform.translate = {-2, 0, -2};
  ground.friction = 0.5;
  EnvironmentSpec hammer = obstacle("hammer", BoxShape{{0.2, 0.2, 0.2}, {{1, 1, 1}}});
  hammer.motion = {{3, {0, 0.5, 0}}, {3.2, {0, 0.107, 0}}};
  EnvironmentSpec wheel = obstacle("wheel", BoxShape{{0.2, 0.2, 0.2}, {{1, 1, 1}}});
  wheel.motion = {{0, {9, 0.5, 0}}, {100, {9, 0.5, 0}, {0, 1, 0}, 36000}};
  scene.environment = {ground, hammer, wheel};
  scene.sleep = Sleep{0.02, 0.2};
  return scene;
}

bool asleep(const Simulation& simulation) { return simulation.solver().sleep()->particles > 0; }

class ARestingSheet : public testing::TestWithParam<const char*> {};

TEST_P(ARestingSheet, FallsAsleepAndIsStillAtNoCostUntilItIsHit) {
  Scene scene = resting_sheet(GetParam());
  Simulation simulation(scene, {.threads = 1});
  while (simulation.time() < 1.5) simulation.step();
  ASSERT_TRUE(asleep(simulation));
  const double since = simulation.solver().sleep()->since;
  EXPECT_GT(since, 0.23) << "0.05 s of fall, and 0.2 s of rest";
  EXPECT_EQ(simulation.measure().speed_max, 0);
  const auto hash = simulation.state_hash();
  const auto passes = simulation.solver().pass_seconds();
  while (simulation.time() < 2.9) {
    simulation.step();
    ASSERT_EQ(simulation.state_hash(), hash) << simulation.time();
  }
  EXPECT_EQ(simulation.solver().pass_seconds(), passes) << "no pass ran";
  EXPECT_EQ(simulation.solver().sleep()->since, since);
  while (simulation.time() < 3.3) simulation.step();
  EXPECT_NE(simulation.state_hash(), hash) << "the hammer has hit it";
  EXPECT_FALSE(asleep(simulation)) << "0.2 s have not passed since";
  while (simulation.time() < 6) simulation.step();
  EXPECT_TRUE(asleep(simulation));
}

TEST_P(ARestingSheet, IsStillForTenThousandSteps) {
  Scene scene = resting_sheet(GetParam());
  scene.environment.resize(1);
  Simulation simulation(scene, {.threads = 1});
  while (simulation.time() < 1.5) simulation.step();
  const auto hash = simulation.state_hash();
  const auto passes = simulation.solver().pass_seconds();
  for (int step = 0; step < 10'000; ++step) simulation.step();
  EXPECT_EQ(simulation.state_hash(), hash);
  EXPECT_EQ(simulation.solver().pass_seconds(), passes);
  simulation.wake();
  simulation.step();
  if (scenes_run_on_host()) {
    EXPECT_NE(simulation.solver().pass_seconds(), passes) << "it was woken";
  }
}

INSTANTIATE_TEST_SUITE_P(Under, ARestingSheet, testing::Values("pbd", "desbrun"));

/// The run is stopped and resumed before it sleeps, while it sleeps, and after it was woken.
TEST(Sleep, IsResumed) {
  const TemporaryFolder folder;
  const Scene scene = resting_sheet();
  const std::string path = folder / "checkpoint";
  Simulation whole(scene, {.threads = 1});
  std::vector<std::uint64_t> hashes;
  for (const int stop : {15, 60, 190}) {
    while (whole.steps() < stop) whole.step();
    whole.save_checkpoint(path);
    Simulation rest(scene, {.threads = 1});
    rest.load_checkpoint(path);
    EXPECT_EQ(rest.solver().sleep()->particles, whole.solver().sleep()->particles);
    Simulation same(scene, {.threads = 1});
    same.load_checkpoint(path);
    for (int step = 0; step < 30; ++step) rest.step(), whole.step();
    EXPECT_EQ(rest.state_hash(), whole.state_hash()) << stop;
    EXPECT_EQ(rest.solver().sleep()->since, whole.solver().sleep()->since) << stop;
  }
}

/// At its highest point a thrown particle is slow, but not for long.
TEST(Sleep, DoesNotTakeWhatIsSlowForAMoment) {
  Scene scene = scene_of({particle({0, 0, 0}, {0, 1, 0})}, kEarth, 0.001);
  scene.sleep = Sleep{0.1, 0.05};  // 0.02 s within 0.1 m/s
  Simulation simulation(scene, {.threads = 1});
  while (simulation.time() < 0.3) {
    simulation.step();
    ASSERT_FALSE(asleep(simulation)) << simulation.time();
  }
}

/// A body that has never moved sleeps after the time `after`: not a step earlier or later.
TEST(Sleep, ComesWithTheStepThatWasAskedFor) {
  Scene scene = scene_of({particle({0, 0, 0})}, {0, 0, 0}, 0.01);
  scene.sleep = Sleep{0.1, 0.1};
  Simulation simulation(scene, {.threads = 1});
  for (int step = 1; step < 10; ++step) {
    simulation.step();
    EXPECT_FALSE(asleep(simulation)) << step;
  }
  simulation.step();
  EXPECT_TRUE(asleep(simulation));
}

/// A box that turns beside it may touch it at any time: nothing sleeps before it stops.
TEST(Sleep, DoesNotComeBesideWhatMoves) {
  Scene scene = scene_of({particle({0, 0, 0})}, {0, 0, 0}, 0.01);
  scene.environment = {obstacle("box", BoxShape{{0.2, 0.2, 0.2}, {{1, 1, 1}}})};
  scene.environment[0].motion = {{0, {0.15, 0, 0}}, {0.5, {0.15, 0, 0}, {0, 1, 0}, 90}};
  scene.sleep = Sleep{0.1, 0.1};
  Simulation simulation(scene, {.threads = 1});
  for (int step = 1; step <= 55; ++step) {
    simulation.step();
    ASSERT_FALSE(asleep(simulation)) << step;
  }
  while (simulation.steps() < 61) simulation.step();
  EXPECT_TRUE(asleep(simulation));
}

TEST(Sleep, EndsWhereAPinIsMoved) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {0, -1, 0}, 10)}, kEarth, 0.01);
  scene.bodies[0].constraints = {stiff("distance", {"edges"})};
  scene.sleep = Sleep{0.3, 0.1};
  Simulation simulation(scene, {.threads = 1});
  while (simulation.time() < 2 && !asleep(simulation)) simulation.step();
  ASSERT_TRUE(asleep(simulation));
  const auto hash = simulation.state_hash();
  simulation.move_pin(0, {0.1, 0, 0});
  EXPECT_FALSE(asleep(simulation));
  simulation.step();
  EXPECT_NE(simulation.state_hash(), hash);
}

TEST(Sleep, IsReportedAndPlanned) {
  const Scene scene = resting_sheet();
  EXPECT_NE(plan(Simulation(scene, {.threads = 1})).find("\nsleep:\n  below_speed: 0.02 m/s\n  after: 0.2 s\n"),
            std::string::npos);
  Simulation simulation(scene, {.threads = 1});
  const auto reported = [&] { return nlohmann::json::parse(simulation.report("finished"))["sleep"]; };
  EXPECT_EQ(reported(), (nlohmann::json{{"particles", 0}}));
  while (!asleep(simulation)) simulation.step();
  EXPECT_EQ(reported(), (nlohmann::json{{"particles", 81}, {"since_s", simulation.time()}}));
}

TEST(Sleep, IsNotThereUnlessNamed) {
  Scene scene = resting_sheet();
  scene.sleep.reset();
  Simulation simulation = after(scene, 2);
  EXPECT_FALSE(simulation.solver().sleep());
  EXPECT_EQ(simulation.solver().pass_seconds()[int(Pass::Sleep)], 0);
  EXPECT_FALSE(nlohmann::json::parse(simulation.report("finished")).contains("sleep"));
}

INSTANTIATE_TEST_SUITE_P(
    Sleep, SameBits,
    testing::Values(SameBitsScene{"Float", [](const auto&) { return resting_sheet(); }, 220, {15, 60, 190}},
                    SameBitsScene{"Double",
                                  [](const auto&) { return resting_sheet("pbd", Precision::Double); },
                                  220,
                                  {15, 60, 190}}),
    name_of_scene);

}  // namespace
}  // namespace malha
