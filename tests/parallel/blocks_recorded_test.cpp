// SPDX-License-Identifier: Apache-2.0
// Recording and replaying launches on an emulated device (blocks.h): an incomplete recording shows in the results.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "host/base/scoped_value.h"
#include "malha/simulation.h"
#include "tests/parallel/blocks_solvers.h"
#include "tests/run_scenes.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

struct AddOne {
  int* number;
  KERNEL void operator()(int i) const { ++number[i]; }
};
TEST(RecordedLaunches, AreRecordedOnceAKey) {
  const Array<Blocks, int> numbers(10, 0);
  Recording<Blocks> recording;
  int recorded = 0;
  const auto ask = [&](int key) {
    repeated_region(
        Blocks{}, 1, recording, [&] { return key_from(key); },
        [&](const Blocks& executor) {
          ++recorded;
          parallel_for(executor, key, AddOne{numbers.data()});
        });
  };
  for (const int key : {10, 3, 10}) ask(key);
  EXPECT_EQ(recorded, 2);
  EXPECT_EQ(numbers.download(), (std::vector<int>{3, 3, 3, 2, 2, 2, 2, 2, 2, 2}));
}

TEST(RecordedLaunches, HoldFillsAndCopiesInTheirOrder) {
  const Array<Blocks, int> numbers(4, 0), copy(4, 0);
  Recording<Blocks> recording;
  for (int round = 0; round < 2; ++round)
    repeated(
        Blocks{}, recording, [] { return std::string(); },
        [&] {
          Memory<Blocks>::fill(numbers.data(), 4, 5);
          parallel_for(Blocks{}, 4, AddOne{numbers.data()});
          Memory<Blocks>::copy(numbers.data(), 4, copy.data());
          parallel_for(Blocks{}, 4, AddOne{numbers.data()});
        });
  EXPECT_EQ(copy.download(), std::vector<int>(4, 6));
  EXPECT_EQ(numbers.download(), std::vector<int>(4, 7));
}

TEST(RecordedLaunches, CannotBeSynchronizedWhileTheyAreRecorded) {
  const Array<Blocks, int> numbers(4, 0);
  Recording<Blocks> recording;
  const auto record = [&](const auto& work) {
    repeated(
        Blocks{}, recording, [] { return std::string(); }, work);
  };
  EXPECT_THROW(record([&] { static_cast<void>(numbers.download()); }), std::logic_error);
  EXPECT_THROW(record([&] { synchronize(Blocks{}); }), std::logic_error);
  record([&] { parallel_for(Blocks{}, 4, AddOne{numbers.data()}); });
  EXPECT_EQ(numbers.download(), std::vector<int>(4, 1)) << "what failed was kept";
}

/// Features that launch the same kernels in every step: a pinned sheet in the wind with attachments, and a damped
/// balloon.
Json steady_scene(const char* solver, const char* precision) {
  Json json = Json::parse(R"({"name": "steady", "gravity": [0, -9.81, 0], "duration": 1,
    "solver": {"dt": 0.01, "substeps": 3, "iterations": 2},
    "wind": {"velocity": [1, 0, 0.5], "drag": 0.001, "density": 1.2},
    "bodies": [
      {"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [20, 20]}}, "mass": 0.2,
       "pins": [{"particles": [0, 20]}],
       "attachments": [{"at": {"nearest": [1, 0, 1]}, "to": {"point": [1, 0.2, 1]}, "compliance": 0.01}],
       "constraints": [{"type": "distance", "elements": ["edges"]}, {"type": "long_range", "limit": 0.02}]},
      {"name": "balloon", "shape": {"sphere": {"radius": 0.3, "subdivisions": 2}}, "mass": 0.1, "damping": 0.2,
       "transform": {"translate": [3, 0, 0]}, "spin": [1, 2, 0],
       "constraints": [{"type": "distance", "elements": ["edges"]}, {"type": "pressure"}]}]})");
  json["solver"]["type"] = solver, json["solver"]["precision"] = precision;
  if (json["solver"]["type"] == "desbrun") json["solver"]["refinement_iterations"] = 1;
  return json;
}

/// A damped net: its only passes between prediction and state update are those before the solve.
Json steady_visits() {
  Json json = steady_scene("pbd", "float");
  json["bodies"].erase(0), json["bodies"][0]["constraints"].erase(1);
  json["wind"].erase("density");
  return json;
}

class SteadySteps : public testing::TestWithParam<std::string> {};

/// All changes between steps that the library allows, after launches were recorded.
TEST_P(SteadySteps, ReplayLaunchesThatHaveNotChanged) {
  const Json scene = Json::parse(GetParam());
  Model model = build_model(parsed(scene));
  model.interactive = true;
  const auto host = make_solver(model, 1), blocks = make_on_blocks(model, {});
  const auto both = [&](const auto& change) { change(*host), change(*blocks); };
  const auto step = [&](const char* after) {
    for (int round = 0; round < 3; ++round) both([](Solver& solver) { solver.step(); });
    EXPECT_TRUE(blocks->save() == host->save()) << after;
  };
  step("the start");
  const std::string start = host->save();
  model.scene.gravity = {0.5, 3, 0};
  both([](Solver& solver) { solver.change_gravity(); });
  step("another gravity");
  model.scene.wind->velocity = {-2, 0, 0}, model.scene.wind->drag = 0.002;
  both([](Solver& solver) { solver.change_wind(); });
  step("another wind");
  const int last = model.count() - 1;
  both([&](Solver& solver) { solver.take({last, {3, 1, 0}, 0.01}); });
  step("something pulled");
  both([&](Solver& solver) { solver.release(last); });
  step("and let go");
  both([&](Solver& solver) { solver.restore(start); });
  step("the start once more");
  if (scene["bodies"].size() == 2) {
    both([](Solver& solver) { solver.move_pins({0}, {{0, 0.1, 0}}); });
    step("a pin moved");
  }
}

/// Launches of the energy guard, which are periodic, do not count.
struct LaunchedAlone final : LaunchObserver {
  std::set<std::string> kernels;
  int replayed = 0;
  void launched(const char* kernel, int) override {
    if (replaying)
      ++replayed;
    else if (!has(kernel, "MeasureRuns<"))
      kernels.insert(kernel);
  }
};

TEST_P(SteadySteps, LaunchNothingThatIsNotRecorded) {
  const Model model = build_model(parsed(Json::parse(GetParam())));
  const auto blocks = make_on_blocks(model, {});
  LaunchedAlone watch;
  const ScopedValue<LaunchObserver*> watched(launch_observer, &watch);
  for (int step = 0; step < 3; ++step) blocks->step();
  EXPECT_EQ(watch.kernels, std::set<std::string>());
  EXPECT_GT(watch.replayed, 20);
}

INSTANTIATE_TEST_SUITE_P(, SteadySteps,
                         testing::Values(steady_scene("pbd", "float").dump(), steady_scene("pbd", "double").dump(),
                                         steady_scene("desbrun", "float").dump(), steady_visits().dump()));

TEST(RecordedLaunches, AreThoseOfWhatChangedMeanwhile) {
  for (const int levels : {0, 2}) {
    BodySpec sheet;
    sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {40, 40}}, sheet.density = 0.2;
    sheet.pins = {ListPin{{0, 40}}};
    sheet.constraints = {stiff("distance", {"edges"})};
    Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 4, Precision::Float);
    scene.solver.levels = levels, scene.solver.levels_interval = 2;
    Model model = build_model(scene);
    const auto host = make_solver(model, 1), blocks = make_on_blocks(model, {});
    for (const double g : {-9.81, 3.0, -9.81}) {
      model.scene.gravity = {0.1, g, 0};
      host->change_gravity(), blocks->change_gravity();
      for (int step = 0; step < 2; ++step) host->step(), blocks->step();
      EXPECT_EQ(blocks->state_hash(), host->state_hash()) << levels << " levels, " << g;
    }
  }
}

}  // namespace
}  // namespace malha
