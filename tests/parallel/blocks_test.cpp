// SPDX-License-Identifier: Apache-2.0
// Kernels and solvers on blocks of many threads have the same bits as on one. First, the emulation finds the errors
// that it is made to find.
#include "tests/parallel/blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "malha/simulation.h"
#include "tests/parallel/blocks_solvers.h"
#include "tests/run_scenes.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

struct CountOnce {
  using Shared = void;
  int* count;
  template <class Group>
  void operator()(const Group& group) const {
    group.for_each(100, [&](int i) { ++count[i]; });
  }
};
/// Increments outside of for_each, so that each thread does it.
struct CountOutside {
  using Shared = void;
  int* count;
  template <class Group>
  void operator()(const Group&) const {
    ++count[0];
  }
};
struct WaitInABranch {
  using Shared = void;
  template <class Group>
  void operator()(const Group& group) const {
    bool odd = false;
    group.for_each(2, [&](int i) { odd = i % 2 == 1; });
    if (odd) group.for_each(1, [](int) {});
  }
};
/// Each number takes the value of the one before, so that the result depends on the order of the threads.
struct ShiftInPlace {
  using Shared = void;
  int* number;
  template <class Group>
  void operator()(const Group& group) const {
    group.for_each(99, [&](int i) { number[i + 1] = number[i]; });
  }
};

TEST(Blocks, DistributeGroupLoopsAndRepeatTheCodeAroundThem) {
  for (const int threads : {1, 32, 128}) {
    std::vector<int> once(100, 0), outside(1, 0);
    parallel_groups(Blocks{threads}, 0, 1, {}, CountOnce{once.data()});
    parallel_groups(Blocks{threads}, 0, 1, {}, CountOutside{outside.data()});
    EXPECT_EQ(once, std::vector<int>(100, 1)) << threads;
    EXPECT_EQ(outside[0], threads);
  }
}

TEST(Blocks, RefuseABarrierThatNotAllThreadsReach) {
  EXPECT_NO_THROW(parallel_groups(Blocks{1}, 0, 1, {}, WaitInABranch{}));
  EXPECT_THROW(parallel_groups(Blocks{32}, 0, 1, {}, WaitInABranch{}), std::logic_error);
}

TEST(Blocks, RevealARaceByTheOrderOfTheirThreads) {
  const auto shifted = [](unsigned seed) {
    std::vector<int> number(100);
    for (int i = 0; i < 100; ++i) number[i] = i;
    parallel_groups(Blocks{32, seed}, 0, 1, {}, ShiftInPlace{number.data()});
    return number;
  };
  EXPECT_EQ(shifted(1), shifted(1));
  EXPECT_NE(shifted(1), shifted(2));
}

struct AddressOf {
  const int* number;
  KERNEL void operator()(int) const {}
};
TEST(Blocks, ReportAKernelWithAPointerToHostMemory) {
  if (!HostAddresses::kCanCheck) GTEST_SKIP() << "the compiler cannot clear the padding of kernels";
  const int number = 7;
  parallel_for(Blocks{}, 1, AddressOf{&number});
  EXPECT_TRUE(
      std::ranges::any_of(HostAddresses::kernels_found(), [](const auto& name) { return has(name, "AddressOf"); }));
}

TEST(Blocks, EndTheProgramWhereTheHostTouchesDeviceMemory) {
  const Array<Blocks, int> array(100, 7);
  EXPECT_EQ(array.get(99), 7);
  EXPECT_EQ(array.download(), std::vector<int>(100, 7));
  EXPECT_DEATH(static_cast<void>(*static_cast<volatile int*>(array.data())), "");
}

/// The number of times that the host waits for a device in a step: reads of its memory; `before_them` steps run first.
double reads_a_step(const Scene& scene, int before_them = 1) {
  const Model model = build_model(scene);
  const auto blocks = make_on_blocks(model, {});
  for (int step = 0; step < before_them; ++step) blocks->step();
  const int before = Memory<Blocks>::reads();
  for (int step = 0; step < 3; ++step) blocks->step();
  return (Memory<Blocks>::reads() - before) / 3.0;
}

TEST(AStepOnADevice, ReadsBackOneFlag) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {12, 12}}, sheet.density = 0.2;
  sheet.pins = {ListPin{{0, 12}}};
  sheet.constraints = {stiff("distance", {"edges"})};
  const auto scene = [&](const BodySpec& body) { return scene_of({body}, kEarth, 1.0 / 60, 4, Precision::Float); };
  EXPECT_EQ(reads_a_step(scene(sheet)), 1) << "visits";
  BodySpec limited = sheet;
  limited.constraints.push_back(stiff("long_range", {}, 1, 0.02));
  EXPECT_EQ(reads_a_step(scene(limited)), 1) << "long range";
  BodySpec balloon;
  balloon.name = "balloon", balloon.shape = SphereShape{0.5, 2}, balloon.mass = 1, balloon.pins = {ListPin{{0}}};
  balloon.constraints = {stiff("distance", {"edges"}), stiff("pressure")};
  EXPECT_EQ(reads_a_step(scene(balloon)), 1) << "pressure";
  Scene blown = scene(sheet);
  blown.wind = Wind{{1, 0, 2}, 0.1, 1.2};
  EXPECT_EQ(reads_a_step(blown), 1) << "air";
  EXPECT_EQ(reads_a_step(load_shipped("desbrun_sheet")), 1) << "Desbrun's filter";
  for (const char* solver : {"pbd", "desbrun"}) {
    BodySpec free = sheet;
    free.pins.clear(), free.damping = 0.1;
    Scene falling = scene(free);
    falling.solver.type = solver, falling.solver.keeps_momenta = true;
    EXPECT_EQ(reads_a_step(falling), 1) << "damping and the corrector, by " << solver;
    falling.bodies[0].constraints.push_back(stiff("long_range", {}, 1, 0.02));
    falling.bodies[0].pins = {ListPin{{0}}}, falling.bodies.push_back(free), falling.bodies[1].name = "other";
    EXPECT_EQ(reads_a_step(falling), 1) << "of which one is held by long range, by " << solver;
  }
}

/// The reads are: which particles pass the broad phase of a mesh, how many queries the lists leave, and those queries;
/// which particles may cross a mesh, and those; and the finite check. Once a step: the capacity of lists, and the
/// energy. Restitution is counted, too.
TEST(AStepOnADevice, ReadsSixTimesASubstepForContactsHoweverManyMeshes) {
  for (const char* name : {"thin_wall", "rotating_sphere", "ramp"}) {
    Scene scene = load_shipped(name);
    // Exact shapes beside meshes read once more, whether the other has moved anything.
    const bool has_both = name == std::string("rotating_sphere");
    EXPECT_LE(reads_a_step(scene, 20), (6 + has_both) * scene.solver.substeps + 2) << name;
    for (EnvironmentSpec& mesh : scene.environment) mesh.restitution = 0.5;
    EXPECT_LE(reads_a_step(scene, 20), (8 + has_both) * scene.solver.substeps + 2) << name << " that bounces";
  }
}

/// The reads are: whether the swept bounds are still valid for the prediction and for the projected motion, whether
/// anything is about to intersect, and the finite check; once a step the energy.
TEST(AStepOnADevice, ReadsFourTimesASubstepForSelfCollisionWhereNothingIsSearched) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {12, 12}}, sheet.density = 0.2;
  sheet.pins = {ListPin{{0, 12}}}, sheet.constraints = {stiff("distance", {"edges"})};
  Scene scene = scene_of({sheet}, {}, 1.0 / 60, 4, Precision::Float);
  scene.self_collision.emplace().thickness = 0.01;
  EXPECT_LE(reads_a_step(scene, 20), 4 * 4 + 1);
}

/// A sheet that falls between a wall, a floor that it bounces off and a ball that rotates: close to several objects at
/// once.
TEST(ContactsOnBlocks, AreTheHostsBetweenSeveralMeshes) {
  for (const char* precision : {"float", "double"}) {
    Json json = Json::parse(R"({"name": "corner", "gravity": [0, -9.81, 0],
      "solver": {"type": "pbd", "dt": 0.01, "substeps": 4, "iterations": 2},
      "bodies": [{"name": "sheet", "shape": {"grid": {"size": [0.5, 0.5], "cells": [12, 12]}}, "mass": 0.1,
                  "transform": {"translate": [0.02, 0.3, 0]}, "velocity": [-2, -4, 0.5],
                  "constraints": [{"type": "distance", "elements": ["edges", "shear"]}]}],
      "environment": [
        {"name": "floor", "shape": {"grid": {"size": [2, 2], "cells": [3, 3]}}, "transform": {"translate": [-1, 0, -1]},
         "sides": "one_sided", "thickness": 0.01, "restitution": 0.5, "friction": 0.2},
        {"name": "wall", "shape": {"box": {"size": [0.1, 1, 2], "cells": [1, 2, 3]}},
         "transform": {"translate": [-0.15, 0.5, 0]}, "sides": "solid", "thickness": 0.015},
        {"name": "ball", "shape": {"sphere": {"radius": 0.1, "subdivisions": 2}},
         "transform": {"translate": [0.2, 0.12, 0.2]}, "sides": "two_sided", "thickness": 0.02,
         "motion": [{"time": 0}, {"time": 0.4, "rotate": {"axis": [0, 0, 1], "degrees": 90}}]}],
      "duration": 0.4})");
    json["solver"]["precision"] = precision;
    const Model model = build_model(parsed(json));
    const auto host = make_solver(model, 1);
    const auto blocks = make_on_blocks(model, {});
    int held = 0;
    std::vector<std::string> states;
    for (int step = 0; step < 40; ++step) {
      host->step();
      blocks->step();
      held += host->measure().contacts;
      states.push_back(host->save());
      ASSERT_TRUE(blocks->save() == states.back()) << precision << ", step " << step;
    }
    for (const int from : {25, 5}) {  // no contacts of later steps may remain
      blocks->restore(states[from]);
      for (int step = from + 1; step < 40; ++step) {
        blocks->step();
        ASSERT_TRUE(blocks->save() == states[step]) << precision << ", step " << step << " from " << from;
      }
    }
    EXPECT_GT(held, 100) << "the case does not occur";
  }
}

TEST(SelfContactsOnBlocks, HaveTheHostsBits) {
  const auto sheet = [](const std::string& name, double y, double speed) {
    BodySpec body;
    body.name = name, body.shape = GridShape{{0.4, 0.4}, {10, 10}}, body.density = 0.2;
    body.transform.translate = {0.1 * y, y, 0.2 * y}, body.velocity = {0, speed, 0};
    body.constraints = {stiff("distance", {"edges", "shear"})};
    return body;
  };
  Scene scene = scene_of({sheet("one", 0, 30), sheet("other", 0.1, -30)}, {}, 1.0 / 60, 2, Precision::Float);
  scene.self_collision.emplace().thickness = 0.01;
  const Model model = build_model(scene);
  const auto host = make_solver(model, 1);
  std::vector<std::unique_ptr<Solver>> all;
  for (const int threads : {1, 32, 128}) all.push_back(make_on_blocks(model, {threads, unsigned(threads)}));
  for (int step = 0; step < 4; ++step) {
    host->step();
    for (const auto& blocks : all) {
      blocks->step();
      EXPECT_TRUE(blocks->save() == host->save()) << step;
    }
  }
  EXPECT_GT(host->facts().self->substeps_truncated, 0) << "nothing had to be held: the case does not occur";
  EXPECT_EQ(all.back()->facts().self->substeps_truncated, host->facts().self->substeps_truncated);
}

/// No kernel has host addresses, except the one that queries Embree for penetration, for which a device's memory is
/// copied to the host.
void expect_no_address_of_the_host(const std::set<std::string>& before) {
  for (const std::string& name : HostAddresses::kernels_found()) {
    if (before.contains(name)) continue;
    EXPECT_TRUE(has(name, "MeasureDepth<")) << name;
  }
}

/// Both run two steps from the state that the host has after a quarter of a second.
class SceneOnBlocks : public testing::TestWithParam<std::string> {
 protected:
  void expect_the_hosts_bits(const Scene& scene, const std::vector<Blocks>& all) {
    const std::set<std::string> before = HostAddresses::kernels_found();
    const Model model = build_model(scene);
    const auto host = make_solver(model, 1);
    const int steps = static_cast<int>(0.25 / scene.solver.dt);
    for (int step = 0; step < steps; ++step) host->step();
    const std::string start = host->save();
    for (int step = 0; step < 2; ++step) host->step();
    for (const Blocks& executor : all) {
      const auto blocks = make_on_blocks(model, executor);
      blocks->restore(start);
      for (int step = 0; step < 2; ++step) blocks->step();
      EXPECT_EQ(blocks->state_hash(), host->state_hash())
          << executor.block << " threads, order " << executor.seed << ", after " << steps << " steps";
      EXPECT_TRUE(blocks->save() == host->save());
      EXPECT_EQ(blocks->measure().kinetic, host->measure().kinetic);
      EXPECT_EQ(blocks->measure().elastic, host->measure().elastic);
    }
    expect_no_address_of_the_host(before);
  }
};

TEST_P(SceneOnBlocks, HasTheHostsBits) {
  expect_the_hosts_bits(load_shipped(GetParam()), {Blocks{1, 4}, Blocks{32, 1}, Blocks{128, 2}});
}

TEST_P(SceneOnBlocks, HasTheHostsBitsInTheOtherPrecision) {
  Scene scene = load_shipped(GetParam());
  Precision& precision = scene.solver.precision;
  precision = precision == Precision::Float ? Precision::Double : Precision::Float;
  expect_the_hosts_bits(scene, {Blocks{32, 3}});
}

INSTANTIATE_TEST_SUITE_P(, SceneOnBlocks, testing::ValuesIn(shipped_scenes()),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace malha
