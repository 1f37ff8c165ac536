// SPDX-License-Identifier: Apache-2.0
// Warnings of scenes that are probably not meant: each is given once, with the ratio that revealed it; and the default
// thickness follows the edges.
#include "host/model/unlikely.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/report/warnings.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A sheet of 1 m over a ball and the ground, with self-collision: nothing in it is unlikely.
Json likely_scene() {
  return Json::parse(R"({
    "name": "likely", "solver": {"type": "pbd", "dt": 0.02}, "gravity": [0, -9.81, 0], "duration": 1,
    "bodies": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [8, 8]}}, "mass": 0.3,
                "transform": {"translate": [-0.5, 0.6, -0.5]},
                "constraints": [{"type": "distance"}, {"type": "distance", "elements": ["shear"]}, {"type": "bending"}]}],
    "environment": [{"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 2}}, "friction": 0.5}],
    "self_collision": {"thickness": 0.01, "friction": 0.3}})");
}

std::vector<std::string> said_of(const Json& scene) { return warnings(build_model(parsed(scene))); }

/// Expects one line that contains these words.
testing::AssertionResult says_once(const Json& scene, const std::vector<std::string>& words) {
  const std::vector<std::string> lines = said_of(scene);
  bool right = lines.size() == 1;
  for (const std::string& word : words) right = right && has(lines[0], word);
  if (right) return testing::AssertionSuccess();
  auto no = testing::AssertionFailure() << lines.size() << " lines";
  for (const std::string& line : lines) no << "\n" << line;
  return no;
}

TEST(UnlikelySettings, AreNotFoundInALikelyScene) { EXPECT_TRUE(said_of(likely_scene()).empty()); }

TEST(UnlikelySettings, AreOtherUnits) {
  Json scene = likely_scene();
  scene.erase("self_collision");
  scene["bodies"][0]["transform"]["scale"] = 200;  // 283 m beside a ball of 1.04 m across its box
  EXPECT_TRUE(says_once(scene, {"body 'sheet'", "270 times", "'ball'", "\"scale\": 0.01"}));
  scene["bodies"][0]["transform"]["scale"] = 100;  // 140 m; over a ground as large as scenes have them, 11 m
  scene["environment"][0]["shape"] = Json::parse(R"({"grid": {"size": [8, 8], "cells": [1, 1]}})");
  scene["environment"][0]["sides"] = "two_sided";
  EXPECT_TRUE(says_once(scene, {"body 'sheet'", "13 times", "'ball'"}));
  scene["bodies"][0]["transform"]["scale"] = 20;  // 28 m, over what may be a table
  scene["environment"][0]["shape"]["grid"]["size"] = {1, 1};
  EXPECT_TRUE(said_of(scene).empty());
  scene = likely_scene();
  scene.erase("environment"), scene.erase("self_collision");
  Json large = scene["bodies"][0];
  large["name"] = "large", large["transform"]["scale"] = 1000;
  scene["bodies"].push_back(large);
  EXPECT_TRUE(says_once(scene, {"body 'large'", "1000 times", "body 'sheet'"}));
}

TEST(UnlikelySettings, AreThicknessesOfSelfCollisionThatTheEdgesDoNotGoWith) {
  Json scene = likely_scene();
  scene.erase("environment");
  scene["self_collision"]["thickness"] = 10;
  scene["bodies"][0]["shape"]["grid"]["cells"] = {2, 2};
  EXPECT_TRUE(says_once(scene, {"body 'sheet'", "20 times its edges, 0.5 m"}));
  scene["self_collision"]["thickness"] = 1e-9;
  EXPECT_TRUE(says_once(scene, {"body 'sheet'", "2e-09 times its edges"}));
}

TEST(UnlikelySettings, AreContactsUnderWhichASheetFloats) {
  Json scene = likely_scene();
  scene.erase("self_collision");
  scene["bodies"][0]["transform"]["scale"] = 0.01;  // edges of 1.25 mm
  EXPECT_TRUE(said_of(scene).empty()) << "the default follows the edges";
  scene["environment"][0]["thickness"] = 0.005;
  EXPECT_TRUE(says_once(scene, {"object 'ball'", "4 times", "0.0013 m", "0.00025 m"}));
}

TEST(UnlikelySettings, AreBodiesThatNothingHoldsTogether) {
  Json scene = likely_scene();
  scene["bodies"][0].erase("constraints");
  EXPECT_TRUE(says_once(scene, {"body 'sheet'", "no \"constraints\"", "81 particles"}));
  scene["bodies"][0]["pins"] = Json::parse(R"([{"box": {"min": [-9, -9, -9], "max": [9, 9, 9]}}])");
  EXPECT_TRUE(said_of(scene).empty()) << "held by its pins";
  scene["bodies"][0].erase("pins");
  scene["bodies"][0]["shape"] = Json::parse(R"({"lattice": {"min": [0, 0, 0], "max": [1, 1, 1], "count": [3, 3, 3]}})");
  scene.erase("self_collision");
  EXPECT_TRUE(said_of(scene).empty()) << "loose particles are meant to be";
}

TEST(UnlikelySettings, AreFrictionsOfPercentAndTheSameConstraintTwice) {
  Json scene = likely_scene();
  scene["environment"][0]["friction"] = 20;
  EXPECT_TRUE(says_once(scene, {"object 'ball'", "20 times"}));
  scene = likely_scene();
  scene["self_collision"]["friction"] = 30;
  EXPECT_TRUE(says_once(scene, {"self_collision", "30 times"}));
  scene = likely_scene();
  scene["bodies"][0]["constraints"][1]["elements"] = {"edges", "shear"};
  EXPECT_TRUE(says_once(scene, {"body 'sheet'", "\"distance\" 2 times"}));
  scene = likely_scene();
  scene["bodies"][0]["constraints"].push_back({{"type", "bending"}});
  EXPECT_TRUE(says_once(scene, {"body 'sheet'", "\"bending\" 2 times"}));
}

TEST(DefaultThickness, IsAFifthOfFineEdgesAndFiveMillimetresOfOthers) {
  for (const auto& [size, thickness] : {std::pair{1.0, 0.005}, {0.2, 0.005}, {0.02, 0.0005}, {0.002, 0.00005}}) {
    Json scene = likely_scene();
    scene.erase("self_collision");
    const double edge = size / 8, expected = std::min(thickness, edge / 5);
    scene["bodies"][0]["transform"] = Json{{"scale", size}, {"translate", {0, 2 * expected, 0}}};
    scene["environment"] = Json::parse(
        R"([{"name": "ground", "shape": {"grid": {"size": [2, 2], "cells": [2, 2]}}, "sides": "one_sided",
             "transform": {"translate": [-0.5, 0, -0.5]}}])");
    scene["gravity"] = {0, -9.81 * size, 0};
    Simulation simulation(parsed(scene), {.threads = 1});
    EXPECT_NEAR(simulation.model().scene.environment[0].thickness, expected, 1e-6 * expected);
    for (int step = 0; step < 50; ++step) simulation.step();
    for (const Vec3& x : simulation.positions()) {
      EXPECT_NEAR(x[1], expected, 0.1 * expected) << size;
      EXPECT_LT(x[1], 0.25 * edge) << "it floats";
    }
    // The scene that is written from it gives the same warnings again.
    const Scene again = parse_scene(to_json(simulation.model().scene), "again.json", ".");
    EXPECT_EQ(again.environment[0].thickness, simulation.model().scene.environment[0].thickness);
  }
}

}  // namespace
}  // namespace malha
