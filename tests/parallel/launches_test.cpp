// SPDX-License-Identifier: Apache-2.0
// The launches of a step are those of the features that its scene names, by the trace of launches and the bytes of each
// owner.
#include "host/report/launches.h"

#include <algorithm>

#include "host/report/plan.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "tests/on_host.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A cloth with distances alone.
Json traced_cloth() {
  return Json::parse(R"({
    "name": "cloth", "solver": {"type": "pbd", "dt": 0.01, "substeps": 4}, "gravity": [0, -9.81, 0], "duration": 1,
    "bodies": [{"name": "cloth", "mass": 1, "shape": {"grid": {"size": [1, 1], "cells": [8, 8]}},
                "pins": [{"row": "first"}], "constraints": [{"type": "distance"}]}]})");
}

struct Traced {
  std::vector<Launches> launches;  // of the first step
  NamedNumbers bytes;              // by owner
  std::int64_t of(const std::string& kernel) const {
    const auto at = std::find_if(launches.begin(), launches.end(), [&](const auto& l) { return l.kernel == kernel; });
    return at == launches.end() ? 0 : at->launches;
  }
};

Traced traced(const Json& scene, int threads = 1) {
  Simulation simulation(parsed(scene), {.threads = threads});
  simulation.step();
  return {simulation.times().launches, memory_parts(simulation.model(), simulation.solver().facts())};
}

TEST(Launches, OfAClothWithDistancesAreThePatchSolvesAlone) {
  const std::vector<Launches> all = traced(traced_cloth()).launches;
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0], (Launches{"SolvePatch<float>", 4, 4})) << "one patch, once a substep";
}

TEST(Launches, AreTheSameOnAnyNumberOfThreads) {
  Json scene = swinging_sheet(true);
  scene["bodies"][0]["shape"]["grid"]["cells"] = {45, 45};  // several patches, several colours
  EXPECT_EQ(traced(scene, 1).launches, traced(scene, 4).launches);
  scene["solver"]["type"] = "desbrun";
  EXPECT_EQ(traced(scene, 1).launches, traced(scene, 4).launches);
}

TEST(Launches, OfAReductionNameItsKernelAndItsItems) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  Json scene = traced_cloth();
  scene["sleep"] = Json::object();
  EXPECT_EQ(traced(scene).launches.back(), (Launches{"MeasureSpeed<float>", 1, 81}));
}

TEST(Launches, AreNoneAsleep) {
  Json scene = traced_cloth();
  scene["sleep"] = {{"speed", 1e9}, {"after", 0}};
  Simulation simulation(parsed(scene), {.threads = 1});
  simulation.step();
  const LaunchTrace trace;
  simulation.step();
  EXPECT_TRUE(trace.list().empty());
}

/// A feature that a scene may name: the position of its JSON, its value, and its value with no effect (null: there is
/// none).
struct NamedBlock {
  const char *name, *pointer, *json, *neutral;
  std::vector<std::string> kernels;  // that it alone launches
  const char* solver = "pbd";
};

const std::vector<NamedBlock>& blocks() {
  static const std::vector<NamedBlock> all{
      {"drag", "/wind", R"({"velocity": [1, 0, 0], "drag": 0.001})", R"({"velocity": [1, 0, 0], "drag": 0})", {"Drag"}},
      {"air",
       "/wind",
       R"({"velocity": [1, 0, 0], "density": 1.2})",
       R"({"velocity": [1, 0, 0], "density": 0})",
       {"FacesInAir", "ApplyWindForces"}},
      {"damping",
       "/bodies/0/damping",
       "0.1",
       "0",
       {"MeasureMomenta", "NoteMomenta", "FindRigidMotion", "DampTowardsRigid"}},
      {"long_range", "/bodies/0/constraints/1", R"({"type": "long_range"})", nullptr, {"LimitTethers"}},
      {"moved pins",
       "/bodies/0/pins/0/motion",
       R"([{"time": 0}, {"time": 1, "translate": [0, 0, 1]}])",
       nullptr,
       {"MoveToTarget", "ArriveAtTarget"}},
      {"attachments",
       "/bodies/0/attachments",
       R"([{"at": {"row": "last"}, "compliance": 0.1}])",
       "[]",
       {"SolveAttachment"}},
      {"environment",
       "/environment",
       R"([{"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 2}}, "transform": {"translate": [0.5, -0.3, 0.5]}}])",
       "[]",
       {"BroadPhaseTest", "FindContact", "InvalidateContacts", "ResolveContact", "ClampTunnelling",
        "ApplyRestitution"}},
      {"self-collision",
       "/self_collision",
       R"({"thickness": 0.02})",
       nullptr,
       {"ComputeDisplacements", "ComputeSweptAabbs", "FindCandidates", "NarrowPhase", "FindViolations",
        "ClampToSweptBounds"}},
      {"tear", "/bodies/0/tear", R"({"strain": 100})", nullptr, {"MeasureExcess"}},
      {"sleep", "/sleep", "{}", nullptr, {"MeasureSpeed"}},
  };
  return all;
}

class Feature : public testing::TestWithParam<int> {
 protected:
  const NamedBlock& block() const { return blocks()[static_cast<std::size_t>(GetParam())]; }
  static Json with(Json scene, const char* pointer, const char* json) {
    scene[Json::json_pointer(pointer)] = Json::parse(json);
    return scene;
  }
};

bool is_of(const Launches& launches, const std::vector<std::string>& kernels) {
  return std::any_of(kernels.begin(), kernels.end(),
                     [&](const std::string& kernel) { return launches.kernel.starts_with(kernel + "<"); });
}

TEST_P(Feature, LaunchesWhatNoOtherFeatureLaunches) {
  const Traced named = traced(with(traced_cloth(), block().pointer, block().json));
  for (std::size_t k = 0; k < blocks().size(); ++k) {
    if (static_cast<int>(k) == GetParam()) continue;
    for (const Launches& launches : named.launches)
      EXPECT_FALSE(is_of(launches, blocks()[k].kernels)) << launches.kernel << " of " << blocks()[k].name;
  }
  EXPECT_TRUE(std::any_of(named.launches.begin(), named.launches.end(), [&](const Launches& launches) {
    return is_of(launches, block().kernels);
  })) << "none of its own";
}

TEST_P(Feature, CostsNothingWhereTheSceneDoesNotNameIt) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  const Traced never = traced(traced_cloth());
  // With every other feature named, the launches and the bytes are those of a scene that never had this one.
  Json all = traced_cloth(), others = all;
  for (const NamedBlock& other : blocks()) {
    // these exclude some of the others
    if (std::string(other.name) == "tear" || std::string(other.name) == "drag") continue;
    all = with(all, other.pointer, other.json);
    if (other.name != block().name) others = with(others, other.pointer, other.json);
  }
  const Traced rest = traced(others), whole = traced(all);
  for (const Launches& launches : rest.launches) EXPECT_FALSE(is_of(launches, block().kernels)) << launches.kernel;
  for (const Launches& launches : rest.launches)
    EXPECT_LE(launches.launches, whole.of(launches.kernel)) << launches.kernel << " runs oftener without";
  if (block().neutral == nullptr) return;
  const Traced neutral = traced(with(traced_cloth(), block().pointer, block().neutral));
  EXPECT_EQ(neutral.launches, never.launches);
  EXPECT_EQ(neutral.bytes, never.bytes);
}

INSTANTIATE_TEST_SUITE_P(Named, Feature, testing::Range(0, 10));

/// The cloth without pins, with the momentum corrector or without.
Json free_cloth(const char* corrector) {
  Json scene = traced_cloth();
  scene["bodies"][0].erase("pins");
  if (corrector != nullptr) scene["solver"]["corrector"] = corrector;
  return scene;
}

TEST(Launches, OfTheCorrectorAreSixAStepWhereABodyIsFree) {
  const Traced never = traced(free_cloth(nullptr)), off = traced(free_cloth("off"));
  EXPECT_EQ(off.launches, never.launches);
  EXPECT_EQ(off.bytes, never.bytes);
  const Traced kept = traced(free_cloth("inertia"));
  ASSERT_EQ(kept.launches.size(), 6u);
  EXPECT_EQ(kept.of("SolvePatch<float>"), 4);
  EXPECT_EQ(kept.of("MeasureMomenta<float, float, false, false>"), 1);
  EXPECT_EQ(kept.of("MeasureMomenta<float, float, false, true>"), 1);
  EXPECT_EQ(kept.of("StoreMomenta"), 2);
  EXPECT_EQ(kept.of("ComputeMomentumCorrection<float>"), 1);
  EXPECT_EQ(kept.of("AddRigidMotion<float>"), 1);
  Json held = traced_cloth();
  held["solver"]["corrector"] = "inertia";
  EXPECT_EQ(traced(held).launches, traced(traced_cloth()).launches) << "nothing is free";
  EXPECT_EQ(traced(held).bytes, traced(traced_cloth()).bytes);
}

/// The number of launches by the lines of the plan, and by the trace.
void expect_planned_launches(const Json& scene, const std::vector<UserConstraint>& own = {}) {
  Simulation simulation(parsed(scene), {.threads = 1, .constraints = own});
  std::int64_t planned = 0, launched = 0;
  const Json of_plan = Json::parse(plan_json(simulation));
  for (const auto& [pass, launches] : of_plan["launches_a_step"].items()) planned += launches.get<std::int64_t>();
  simulation.step();
  for (const Launches& of : simulation.times().launches) launched += of.launches;
  EXPECT_EQ(launched, planned) << plan(simulation);
}

TEST(Launches, OfAMembraneByDesbrunAreThoseOfThePlanThatNamesIt) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  Json scene = traced_cloth();
  scene["solver"] = {{"type", "desbrun"}, {"dt", 0.01}, {"substeps", 2}, {"refinement_iterations", 1}};
  scene["bodies"][0]["constraints"] = Json::parse(R"([{"type": "membrane", "young_modulus": 100}])");
  expect_planned_launches(scene);
  const Simulation simulation(parsed(scene), {.threads = 1});
  EXPECT_TRUE(has(plan(simulation), "\n  membrane: ")) << plan(simulation);
  EXPECT_GT(Json::parse(simulation.report("planned"))["springs"]["membrane"], 0);
}

TEST(Launches, OfTheCorrectorAreAsManyAsThePlanSaysWhateverLiesBetween) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  Json drag = free_cloth("inertia"), contact = drag, damped = drag;
  drag["wind"] = {{"velocity", {1, 0, 0}}, {"drag", 0.001}};
  damped["bodies"][0]["damping"] = 0.1;
  contact["environment"] = Json::parse(
      R"([{"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 2}}, "transform": {"translate": [0.5, -0.3, 0.5]}}])");
  contact["solver"]["iterations"] = 2;
  Json bounces = contact;
  bounces["environment"][0]["restitution"] = 0.5;
  Json balloon = free_cloth("inertia");
  balloon["bodies"][0]["shape"] = {{"sphere", {{"radius", 0.5}, {"subdivisions", 1}}}};
  balloon["bodies"][0]["constraints"].push_back({{"type", "pressure"}});
  for (const Json& scene : {free_cloth("inertia"), drag, damped, contact, bounces, balloon})
    expect_planned_launches(scene);
}

TEST(Launches, OfPressureAreAsManyAsThePlanSaysByBothMethods) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  Json scene = traced_cloth();
  scene["bodies"][0]["shape"] = {{"sphere", {{"radius", 0.5}, {"subdivisions", 1}}}};
  scene["bodies"][0]["constraints"].push_back({{"type", "pressure"}});
  for (const bool pinned : {true, false}) {
    pinned ? void(scene["bodies"][0]["pins"] = Json::parse(R"([{"particles": [0]}])"))
           : void(scene["bodies"][0].erase("pins"));
    for (const char* type : {"pbd", "desbrun"}) {
      scene["solver"] = {{"type", type}, {"dt", 0.01}, {"substeps", 3}, {"iterations", 2}};
      expect_planned_launches(scene);
    }
  }
}

TEST(Launches, OfAUserConstraintAreAsManyAsThePlanSays) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  UserConstraint own;
  own.particles = {40, 41, 41, 50};  // two constraints that share a particle: two batches
  own.evaluate = [](const UserBatch& batch) {
    for (int c = 0; c < batch.count; ++c) {
      batch.C[c] = 0;
      for (int k = 0; k < 2; ++k) batch.gradient[2 * c + k] = {k == 0 ? -1.0 : 1.0, 0, 0};
    }
  };
  Json scene = traced_cloth();
  scene["solver"]["iterations"] = 2;
  expect_planned_launches(scene, {own});
}

TEST(Launches, OfTheTraceAreAsManyAsThePlanSays) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "a device's launches are others";
  Json scene = traced_cloth();
  for (const NamedBlock& other : blocks())
    if (const std::string name = other.name; name != "tear" && name != "self-collision")
      scene[Json::json_pointer(other.pointer)] = Json::parse(other.json);
  for (const char* type : {"pbd", "desbrun"}) {
    scene["solver"]["type"] = type;
    expect_planned_launches(scene);
  }
}

TEST(Launches, AreInTheReport) {
  Simulation simulation(parsed(traced_cloth()), {.threads = 1});
  EXPECT_FALSE(Json::parse(simulation.report("planned")).contains("launches_of_first_step"));
  simulation.step(), simulation.step();
  const Json report = Json::parse(simulation.report("finished"));
  EXPECT_EQ(report["launches_of_first_step"],
            Json::array({{{"kernel", "SolvePatch<float>"}, {"launches", 4}, {"items", 4}}}));
}

}  // namespace
}  // namespace malha
