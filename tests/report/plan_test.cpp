// SPDX-License-Identifier: Apache-2.0
// The output of malha plan describes what runs, and nothing that the scene does not need.
#include "host/report/plan.h"

#include "host/report/report.h"
#include "host/solver/solver.h"
#include "tests/on_host.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

std::string plan_of(const Json& scene, const SimulationOptions& options = {.threads = 1}) {
  return plan(Simulation(parsed(scene), options));
}

bool says(const std::string& plan, const std::string& line) { return has("\n" + plan, "\n" + line + "\n"); }

/// The plan without the lines that depend on the machine.
std::string portable_plan_of(const Json& scene) {
  std::string text;
  std::istringstream lines(plan_of(scene));
  for (std::string line; std::getline(lines, line);)
    if (!line.starts_with("instructions: ") && !line.starts_with("  peak: ")) text += line + "\n";
  return text;
}

/// Only what every scene has: particles that move.
Json dust() {
  return Json::parse(R"({
    "name": "dust", "solver": {"type": "pbd", "dt": 0.01, "substeps": 3}, "duration": 1,
    "bodies": [{"name": "dust", "mass": 1, "shape": {"lattice": {"min": [0,0,0], "max": [1,1,1], "count": [3,3,3]}}}]})");
}

/// A scene with every feature.
Json balloon_in_the_wind() {
  return Json::parse(R"({
    "name": "balloon", "gravity": [0, -9.81, 0], "wind": {"velocity": [1, 0, 0], "drag": 0.001, "density": 1.2}, "sleep": {}, "duration": 2,
    "solver": {"type": "pbd", "dt": 0.02, "substeps": 4, "iterations": 3, "precision": "double"},
    "bodies": [{
      "name": "balloon", "shape": {"sphere": {"radius": 0.5, "subdivisions": 2}}, "mass": 0.3, "damping": 0.1,
      "transform": {"translate": [0, 0.496, 0]},
      "pins": [{"particles": [0]}],
      "constraints": [{"type": "distance", "compliance": 0.001}, {"type": "distance_limit", "limit": 0.2},
                      {"type": "bending", "stiffness": 0.1}, {"type": "pressure"},
                      {"type": "long_range"}]}],
    "environment": [{"name": "ground", "shape": {"box": {"size": [6, 1, 6], "cells": [1, 1, 1]}}, "restitution": 0.5,
                     "transform": {"translate": [0, -0.5, 0]}}]})");
}

TEST(Plan, AsJsonHasTheLaunchesOfTheText) {
  for (const Json& scene : {dust(), balloon_in_the_wind()}) {
    Simulation simulation(parsed(scene), {.threads = 1});
    const std::string text = plan(simulation);
    const Json json = Json::parse(plan_json(simulation));
    EXPECT_EQ(json["particles"], simulation.model().count());
    ASSERT_FALSE(json["launches_a_step"].empty());
    for (const auto& [pass, launches] : json["launches_a_step"].items())
      EXPECT_TRUE(says(text, "  " + pass + ": " + std::to_string(launches.get<int>()))) << pass;
    EXPECT_FALSE(json.contains("launches_of_first_step"));
    simulation.step();
    EXPECT_EQ(Json::parse(plan_json(simulation))["launches_of_first_step"].size(), simulation.times().launches.size());
  }
}

TEST(Plan, OfLooseParticlesIsOnePassAndNothingElse) {
  EXPECT_EQ(portable_plan_of(dust()),
            "scene: dust\n"
            "solver:\n"
            "  type: pbd\n"
            "  precision: float\n"
            "  dt: 0.01 s\n"
            "  substeps: 3\n"
            "  iterations: 1\n"
            "threads: 1\n"
            "steps: 100\n"
            "bodies: 1\n"
            "particles: 27\n"
            "patches:\n"
            "  count: 1\n"
            "  patch_colors: 1\n"
            "  max_patch_slots: 91\n"
            "step:\n"
            "  patch_solves: by_step\n"
            "  recorded: steps\n"
            "  substep: solve_substep\n"
            "launches_a_step:\n"
            "  fused_solve: 3\n"
            "memory:\n"
            // x, its rounding error, v, displacement: twelve numbers, each in four rows of 16; w of 27 and a pack of 16
            // more.
            "  particles: 3244 B\n"
            // 3008 for the patch memory: 27 and four spare packs, eight numbers each, in cache lines
            "  patches: 3068 B\n"
            // Points twice in double, w, numbers, class: 61 a particle; where the body and its patch begin and end.
            "  model: 1679 B\n"
            "  checkpoint: 1026 B\n"
            "embree: no\n");
}

TEST(Plan, SaysWhatADurationThatIsNoMultipleOfTheStepBecomes) {
  Json scene = dust();
  scene["solver"]["dt"] = 0.3, scene["duration"] = 0.5;
  EXPECT_TRUE(
      says(plan_of(scene), "duration_rounding: the duration, 0.5 s, is 1.66667 steps of 0.3 s: 2 are run, to 0.6 s"));
  scene["duration"] = 0.6;
  EXPECT_FALSE(has(plan_of(scene), "the duration")) << "a multiple needs no word";
}

TEST(Plan, NamesConstraintsWithRunsAndBatches) {
  const Json scene = balloon_in_the_wind();
  const Simulation simulation(parsed(scene), {.threads = 1});
  const std::string text = plan(simulation);
  EXPECT_TRUE(says(text, "particles: 162")) << text;
  EXPECT_TRUE(says(text, "particles_pinned: 1")) << text;
  // 12 iterations a step, each there and back over 480 edges twice and 480 hinges, and 161 attachments and one
  // pressure.
  EXPECT_TRUE(says(text, "projections_a_step: " + std::to_string(12 * (2 * 3 * 480 + 161 + 1)))) << text;
  EXPECT_EQ(simulation.solver().facts().sets.size(), 3u);
  for (const SetStats& set : simulation.solver().facts().sets) {
    EXPECT_EQ(set.constraints, 480);
    std::string line = "  " + set.type + ": count 480, ";
    if (set.in_runs > 0) line += "contiguous " + std::to_string(set.in_runs) + ", ";
    line += "max_colors_per_patch " + std::to_string(set.most_batches) + ", ";
    line += set.type == "bending" ? "stiffness 0.1" : set.type == "distance" ? "compliance 0.001" : "stiffness 1";
    EXPECT_TRUE(says(text, line)) << line << " is not in\n" << text;
  }
  EXPECT_TRUE(says(text, "  pressure: count 1, particles 162, triangles 320")) << text;
  EXPECT_TRUE(says(text, "  long_range: count 161, particles 161")) << text;
}

TEST(Plan, NamesPatches) {
  const std::string small = plan_of(balloon_in_the_wind());
  EXPECT_TRUE(has(small, "\npatches:\n  count: 1\n  patch_colors: 1\n")) << small;
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"]["grid"]["cells"] = {45, 45};
  const Simulation simulation(parsed(scene), {.threads = 1});
  const PatchStats& patches = simulation.solver().facts().patches;
  EXPECT_GT(patches.patches, 1);
  EXPECT_EQ(patches.colours, 2) << "strips alternate";
  EXPECT_GE(patches.most_slots * patches.patches, 46 * 46);
  const std::string lines = "patches:\n  count: " + std::to_string(patches.patches) + "\n  patch_colors: 2\n" +
                            (patches.columns > 0 ? "  soa_patches: " + std::to_string(patches.columns) + "\n" : "") +
                            "  max_patch_slots: " + std::to_string(patches.most_slots);
  EXPECT_TRUE(says(plan(simulation), lines)) << plan(simulation);
}

TEST(Plan, CountsBytesByOwnerAsTheReportDoes) {
  const Simulation simulation(parsed(balloon_in_the_wind()), {.threads = 1});
  const std::string text = plan(simulation);
  const auto kib = [](const Json& bytes) {
    char line[32];
    if (bytes < 10'000) return bytes.dump() + " B";
    std::snprintf(line, sizeof line, "%.1f KiB", bytes.get<double>() / 1024);
    return std::string(line);
  };
  const Json memory = Json::parse(simulation.report("planned"))["memory"];
  EXPECT_TRUE(says(text, "  particles: " + kib(memory["particles_bytes"]))) << text;
  EXPECT_TRUE(says(text, "  constraints: " + kib(memory["constraints_bytes"]))) << text;
  EXPECT_TRUE(says(text, "  patches: " + kib(memory["patches_bytes"]))) << text;
  EXPECT_TRUE(says(text, "  model: " + kib(memory["model_bytes"]))) << text;
  EXPECT_TRUE(says(text, "  collision: " + kib(memory["collision_bytes"]))) << text;
  EXPECT_TRUE(says(text, "memory_not_counted: Embree")) << text;
  EXPECT_TRUE(says(text, "embree: yes\nenvironment_objects: 1")) << text;
}

/// Its 4 substeps of 3 iterations, with one obstacle: four launches detect its contacts, three solve them, and one
/// moves what bounced to where it arrives.
TEST(Plan, CountsLaunches) {
  const std::string text = plan_of(balloon_in_the_wind());
  for (const char* line : {"  damping: 16", "  prediction: 8", "  collision: 28", "  projection: 12", "  pressure: 60",
                           "  long_range: 12", "  air: 8", "  contact: 28", "  state: 8", "  sleep: 1"})
    EXPECT_TRUE(says(text, line)) << line << " is not in\n" << text;
  Json smooth = balloon_in_the_wind();
  smooth["environment"][0].erase("restitution");
  EXPECT_TRUE(says(plan_of(smooth), "  contact: 16")) << "an impact without restitution is stopped too";
  EXPECT_TRUE(says(plan_of(smooth), "  state: 4"));
}

/// A cloth that hangs by a row and uses levels, small enough for a test.
Json cloth_with_levels(int most) {
  Json scene = Json::parse(R"({
    "name": "cloth", "solver": {"type": "pbd", "dt": 0.01, "substeps": 5}, "gravity": [0, -9.81, 0], "duration": 1,
    "bodies": [{"name": "cloth", "mass": 1, "shape": {"grid": {"size": [1, 1], "cells": [40, 40]}},
                "pins": [{"row": "first"}], "constraints": [{"type": "distance", "elements": ["edges", "shear"]}]}]})");
  scene["solver"]["levels"] = most;
  return scene;
}

TEST(Plan, ListsLevels) {
  const std::string text = plan_of(cloth_with_levels(2));
  EXPECT_TRUE(says(text, "levels_interval: 2")) << text;
  // Every second row and column of 41 x 41: 21 x 21, and of these 11 x 11.
  EXPECT_TRUE(has(text, "\n  particles 441, constraints ")) << text;
  EXPECT_TRUE(has(text, "\n  particles 121, constraints ")) << text;
  const Simulation simulation(parsed(cloth_with_levels(2)), {.threads = 1});
  const double bytes = static_cast<double>(simulation.solver().facts().level_bytes);
  char kib[32];
  std::snprintf(kib, sizeof kib, "  levels: %.1f KiB", bytes / 1024);
  EXPECT_TRUE(says(text, kib)) << text;
  // The minimum of each particle of a level: its position and displacement, 12 bytes each, and the inverse mass.
  EXPECT_GT(bytes, (441 + 121) * 28);
}

TEST(Plan, SaysNothingOfLevelsWhereThereAreNone) {
  Json scene = cloth_with_levels(1);
  scene["bodies"][0]["shape"]["grid"]["cells"] = {10, 10};
  scene["solver"]["levels"] = "off";
  const std::string off = portable_plan_of(scene);
  EXPECT_FALSE(has(off, "level")) << off;
  scene["solver"]["levels"] = "auto";  // 10 edges to the pins are no long way
  EXPECT_EQ(portable_plan_of(scene), off);
}

/// Compares the launches of the first step with those that the plan lists for levels.
TEST(Plan, CountsWhatLevelsLaunch) {
  const char* blocks[] = {"{}",                                                   // whole steps in one region
                          R"({"wind": {"velocity": [0, 0, 1], "drag": 0.001}})",  // fused substeps
                          R"({"environment": [{"name": "far", "shape": {"box": {"size": [1, 1, 1], "cells": [1, 1, 1]}},
                           "transform": {"translate": [0, -9, 0]},
                           "motion": [{"time": 0}, {"time": 9, "translate": [1, 0, 0]}]}]})"};  // passes of their own
  for (const char* block : blocks)
    // 0: with a compliance, and pins that are released, after which the levels change
    for (const int every : {1, 2, 3, 0}) {
      Json scene = cloth_with_levels(3);
      if (every == 0) scene["bodies"][0]["constraints"][0]["compliance"] = 1e-6;
      if (every == 0) scene["bodies"][0]["pins"][0]["release_time"] = 0.5;
      scene.update(Json::parse(block));
      scene["solver"]["levels_interval"] = every > 0 ? every : 2;
      const auto launched = [&] {
        Simulation simulation(parsed(scene), {.threads = 1});
        simulation.step();
        std::int64_t all = 0;
        for (const Launches& of : simulation.times().launches) all += of.launches;
        return all;
      };
      const std::string text = plan_of(scene);
      const std::int64_t with = launched();
      scene["solver"]["levels"] = "off";
      EXPECT_TRUE(says(text, "  levels: " + std::to_string(with - launched()))) << with << " " << launched() << "\n"
                                                                                << text;
    }
}

/// Scenes between the two above, each without one feature.
class PlanPasses : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  PlanPasses() : scene_(balloon_in_the_wind()) {
    for (const std::string& pointer : GetParam()) {
      const Json::json_pointer at(pointer);
      scene_[at.parent_pointer()].is_array() ? scene_[at.parent_pointer()].erase(std::stoul(at.back()))
                                             : void(scene_[at.parent_pointer()].erase(at.back()));
    }
  }
  Json scene_;
};

TEST_P(PlanPasses, AreThoseThatAStepSpendsTimeIn) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "passes are timed on the host alone";
  Simulation simulation(parsed(scene_), {.threads = 1});
  const std::string text = plan(simulation);
  simulation.step();
  const std::string passes = text.substr(text.find("launches_a_step:"));
  for (std::size_t k = 0; k < kPassNames.size(); ++k) {
    const std::string name = "\n  " + std::string(kPassNames[k]);
    EXPECT_EQ(has(passes, name + ": "), simulation.solver().pass_seconds()[k] > 0) << kPassNames[k] << " in\n" << text;
  }
}

TEST_P(PlanPasses, HaveNoLineAboutWhatTheSceneLeavesOut) {
  const std::string text = plan_of(scene_);
  for (const char* kind : {"distance", "distance_limit", "bending", "pressure", "long_range"}) {
    bool named = false;
    for (const Json& c : scene_["bodies"][0]["constraints"]) named = named || c["type"] == kind;
    EXPECT_EQ(text.find("  " + std::string(kind) + ": ") != std::string::npos, named) << kind << " in\n" << text;
  }
  for (const char* word : {"collision", "contact", "Embree"})
    EXPECT_EQ(text.find(word) != std::string::npos, scene_.contains("environment")) << word << " in\n" << text;
  EXPECT_EQ(text.find("damping") != std::string::npos, scene_["bodies"][0].contains("damping")) << text;
}

const std::string constraints_pointer = "/bodies/0/constraints";
INSTANTIATE_TEST_SUITE_P(
    Of, PlanPasses,
    testing::Values(std::vector<std::string>{}, std::vector<std::string>{"/environment"},
                    std::vector<std::string>{"/bodies/0/damping", "/wind", "/sleep"},
                    std::vector<std::string>{"/environment/0/restitution", constraints_pointer + "/4",
                                             constraints_pointer + "/3"},
                    std::vector<std::string>{constraints_pointer + "/2", constraints_pointer + "/1"},
                    std::vector<std::string>{"/environment", "/bodies/0/damping", constraints_pointer}));

TEST(Plan, SaysThatFacesWereLeftOut) {
  const TemporaryFolder folder;
  Json scene = dust();
  scene["bodies"][0]["shape"] = {
      {"mesh", folder.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 2 4 3\n")}};
  EXPECT_TRUE(says(plan_of(scene), "zero_area_faces_dropped: 1")) << plan_of(scene);
}

}  // namespace
}  // namespace malha
