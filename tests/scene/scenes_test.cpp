// SPDX-License-Identifier: Apache-2.0
// Every shipped scene is run and compared with its own "expect". Builds with assertions (sanitizers), which are some
// ten times slower, run only its first steps, which must stay finite.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "host/report/warnings.h"
#include "tests/run_scenes.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Mesh files of the scene that are missing; the scans are too large for the repository.
std::vector<std::string> missing_meshes(const Scene& scene) {
  std::vector<std::string> missing;
  const auto look = [&missing](const Shape& shape) {
    const auto* file = std::get_if<MeshFile>(&shape);
    if (file && !std::filesystem::exists(file->path)) missing.push_back(file->path);
  };
  for (const BodySpec& body : scene.bodies) look(body.shape);
  for (const EnvironmentSpec& environment : scene.environment) look(environment.shape);
  return missing;
}

class ShippedScene : public testing::TestWithParam<std::string> {};

TEST_P(ShippedScene, MeetsItsExpectations) {
  const Scene scene = load_shipped(GetParam());
  for (const std::string& path : missing_meshes(scene)) FAIL() << path << " is missing; run tools/setup";
  Simulation simulation(scene, {.threads = 1});
#ifdef NDEBUG
  const long long steps = std::llround(scene.duration / scene.solver.dt);
  for (long long step = 1; step <= steps; ++step) {
    ASSERT_NO_THROW(simulation.step());
    if (scene.self_collision && step % 5 == 0) {
      ASSERT_LE(simulation.measure().crossings, scene.expect.max_crossings.at_most.value_or(0)) << "step " << step;
    }
  }
  for (const std::string& line : simulation.failed_expectations()) ADD_FAILURE() << line;
#else
  for (int step = 0; step < 3; ++step) ASSERT_NO_THROW(simulation.step());
  for (const Vec3& x : simulation.positions()) ASSERT_TRUE(std::isfinite(length(x)));
#endif
}

TEST_P(ShippedScene, ExpectsSomethingOfItsEnd) {
  const Expect expect = load_shipped(GetParam()).expect;
  EXPECT_TRUE(expect.bounds_min && expect.bounds_max) << "no box that holds the particles";
  EXPECT_TRUE(expect.max_speed.at_most) << "no highest speed";
}

INSTANTIATE_TEST_SUITE_P(, ShippedScene, testing::ValuesIn(shipped_scenes()),
                         [](const auto& tested) { return tested.param; });

// The parameterised tests above iterate over the folder; this one checks that it has the promised scenes.
TEST(ShippedScenes, AreAllThere) {
  const std::vector<std::string> names = shipped_scenes();
  std::istringstream promised(
      "sheet_shear sheet_no_shear balloon balloon_low balloon_high closed_soft closed_stiff drape_bunny bullets "
      "thin_wall rotating_sphere ramp soft_bunny cantilever folded_sheet crossed_sheets wrapped_balloon crumpled_ball "
      "torn_sheet carried_sheet turning_flag long_cloth flag at_rest sailcloth pillow dressed");
  for (std::string name; promised >> name;) EXPECT_TRUE(std::binary_search(names.begin(), names.end(), name)) << name;
}

// Each example of scenes/README.md is a whole scene, one of its bodies, or some of its keys, which are merged into a
// scene of a hanging sheet.
TEST(ScenesPage, HasExamplesThatAreSound) {
  const std::string page = bytes_of(MALHA_SOURCE_DIR "/scenes/README.md");
  const Json base = Json::parse(R"({
    "name": "example", "solver": {"type": "pbd"}, "gravity": [0, -9.81, 0], "duration": 1,
    "environment": [{"name": "pole", "shape": {"box": {"size": [0.1, 3, 0.1], "cells": [1, 1, 1]}},
                     "transform": {"translate": [9, 0, 9]}}],
    "bodies": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [4, 4]}}, "mass": 1,
                "constraints": [{"type": "distance"}]}]})");
  int examples = 0;
  for (std::size_t at = page.find("```json\n"); at != std::string::npos; at = page.find("```json\n", at)) {
    at += 8;
    const std::string text = page.substr(at, page.find("```", at) - at);
    const Json example = Json::parse(text);
    Json scene = base;
    if (example.contains("shape")) {
      scene["bodies"][0] = example;
      scene["bodies"][0]["name"] = "sheet";
    } else {
      scene.update(example);
    }
    EXPECT_NO_THROW(build_model(parse_scene(scene.dump(), "scenes/README.md", MALHA_SOURCE_DIR "/scenes"))) << text;
    ++examples;
  }
  EXPECT_GE(examples, 19);
}

// The scene on the first page runs without a warning, and its sheet hardly stretches.
TEST(FirstPage, ShowsASheetThatHangs) {
  const std::string page = bytes_of(MALHA_SOURCE_DIR "/README.md");
  const std::size_t begin = page.find("```json\n") + 8;
  const Scene scene = parse_scene(page.substr(begin, page.find("```", begin) - begin), "README.md", ".");
  Simulation simulation(scene, {.threads = 1});
  EXPECT_EQ(warnings(simulation.model()), std::vector<std::string>());
  double lowest = 0;  // of its swing, m
  while (simulation.time() < scene.duration) {
    simulation.step();
    for (const Vec3& x : simulation.positions()) lowest = std::min(lowest, x[1]);
  }
  // 1 m long and pinned at height 0, it swings through the vertical, stretched by its strain in the swing (2 %).
  EXPECT_LT(lowest, -0.95);
  EXPECT_GT(lowest, -1.02);
}

}  // namespace
}  // namespace malha
