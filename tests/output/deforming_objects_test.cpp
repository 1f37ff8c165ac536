// SPDX-License-Identifier: Apache-2.0
// Objects that deform, in all that shows them: pictures, pages and glTF.
#include <gtest/gtest.h>

#include <cmath>

#include "host/attachments/object_motion.h"
#include "host/output/choose_camera.h"
#include "tests/output/gltf_file.h"
#include "tests/output/page_of_a_run.h"

namespace malha {
namespace {

constexpr double kFrameTime = 0.02;  // s

/// A sheet that falls beside the figure, which walks ahead at 1 m/s.
Json walking_scene() {
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["transform"]["translate"] = {2, 1, 0};
  scene["duration"] = 0.4;  // 20 steps
  scene["environment"] = Json::parse(R"([
    {"name": "ground", "shape": {"grid": {"size": [4, 4], "cells": [1, 1]}}, "sides": "one_sided",
     "transform": {"translate": [-2, -0.3, -2]}},
    {"name": "figure", "animation": {"clip": "walk", "loop": true, "speed": 2},
     "motion": [{"time": 0}, {"time": 1, "translate": [0, 0, 1]}]},
    {"name": "ball", "shape": {"sphere": {"radius": 0.1, "subdivisions": 2}},
     "motion": [{"time": 0}, {"time": 1, "translate": [0, 3, 0]}]}])");
  scene["environment"][1]["shape"]["mesh"] = MALHA_SOURCE_DIR "/scenes/meshes/figure.glb";
  return scene;
}

EnvironmentMesh walking_figure() { return Simulation(parsed(walking_scene()), {.threads = 1}).model().environment[1]; }

TEST(DeformingObjects, ArePicturedWhereTheyAre) {
  const EnvironmentMesh figure = walking_figure();
  for (const double time : {0.0, 0.3}) {
    const std::vector<Vec3> points = points_at(figure, time);
    const Drawing drawing = draw_environment(figure, time);
    ASSERT_EQ(drawing.points.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(drawing.points[i][k], static_cast<float>(points[i][k]));
  }
  EXPECT_GT(std::abs(points_at(figure, 0.3)[0][2] - points_at(figure, 0)[0][2]), 0.2);
}

class DeformingObjectsInFiles : public PageOfARun {};

TEST_F(DeformingObjectsInFiles, AreMorphTargetsOfGltf) {
  const EnvironmentMesh figure = walking_figure();
  Json scene = walking_scene();
  scene["outputs"]["frames"] = {{"every", 1}, {"formats", {"glb"}}};
  run_quietly(scene, {.out = (folder_ / "whole").string()});
  const GltfFile file(folder_ / "whole/frames/run.glb");
  const auto& primitive = file.mesh("figure").primitives.at(0);
  const auto base = file.values(primitive.attributes.at("POSITION"));
  const auto& middle = file.node("figure").translation;
  ASSERT_EQ(primitive.targets.size(), 21u);
  for (const int k : {0, 7, 20}) {
    const std::vector<Vec3> points = points_at(figure, k * kFrameTime);
    const auto moved = file.values(primitive.targets[k].at("POSITION"));
    ASSERT_EQ(moved.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(middle[c] + base[i][c] + moved[i][c], points[i][c], 1e-6) << "floats of 2 m, at frame " << k;
  }
  EXPECT_EQ(file.sampler("figure", "weights").input, file.sampler("sheet", "weights").input);
  EXPECT_THROW(file.sampler("figure", "translation"), std::runtime_error);
  EXPECT_NO_THROW(file.sampler("ball", "translation"));

  run_quietly(scene, {.out = (folder_ / "parts").string(), .steps = 9});
  run_quietly(scene, {.out = (folder_ / "parts").string(), .resume = true});
  EXPECT_EQ(bytes_of(folder_ / "parts/frames/run.glb"), bytes_of(folder_ / "whole/frames/run.glb"));
}

/// Largest distance over the grid on which a page rounds coordinates.
double grid_of(const Json& points) {
  double most = 0;
  for (const Json& side : points["side"]) most = std::max(most, side.get<double>() / 65535);
  return most;
}

TEST_F(DeformingObjectsInFiles, HaveTheirPointsInEveryFrameOfAPage) {
  const auto path = page(walking_scene());
  const Json run = runs_in(path)[0];
  EXPECT_EQ(run["moving"], Json({2})) << "the ball alone has poses";
  EXPECT_EQ(run["environment"][1]["deforms"], true);
  ASSERT_EQ(run["frames"].size(), 21u);
  for (const Json& frame : run["frames"]) {
    EXPECT_EQ(frame["deformed"].size(), 1u);
    EXPECT_EQ(frame["poses"].size(), 1u);
  }
  EXPECT_NE(run["frames"][3]["deformed"][0]["data"], run["frames"][4]["deformed"][0]["data"]);
}

TEST_F(DeformingObjectsInFiles, TakeTheirShareOfAPagesMegabytes) {
  Json scene = walking_scene();
  scene["duration"] = 1.6;  // 80 steps
  EXPECT_GT(std::filesystem::file_size(page(scene, "whole")), 2'500'000u);
  scene["outputs"]["page"] = {{"max_megabytes", 2}};
  const auto path = page(scene, "small");
  EXPECT_LE(std::filesystem::file_size(path), 2'000'000u);
  const std::size_t frames = runs_in(path)[0]["frames"].size();
  EXPECT_GT(frames, 10u);
  EXPECT_LT(frames, 81u);
}

TEST_F(DeformingObjectsInFiles, AreReplayedByAPage) {
  NEEDS_BROWSER;
  const auto path = page(walking_scene());
  const Json run = runs_in(path)[0];
  const EnvironmentMesh figure = walking_figure();
  open_still(path);
  for (const int k : {20, 5}) {
    browser().evaluate("malha.seek(" + std::to_string(k * kFrameTime) + ")");
    const Json shown = evaluated("Array.from(malha.views[0].stage.deforming[0].geometry.attributes.position.array)");
    const std::vector<Vec3> points = points_at(figure, k * kFrameTime);
    ASSERT_EQ(shown.size(), 3 * points.size());
    for (std::size_t i = 0; i < shown.size(); ++i)
      ASSERT_NEAR(shown[i].get<double>(), points[i / 3][i % 3], grid_of(run["frames"][k]["deformed"][0]) + 1e-6);
  }
  expect_no_complaints();
}

}  // namespace
}  // namespace malha
