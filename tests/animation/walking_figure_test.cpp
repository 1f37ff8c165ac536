// SPDX-License-Identifier: Apache-2.0
// Clips of whole figures: the one that the repository makes, and two of Khronos's samples where they lie beside it.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "host/base/build_info.h"
#include "host/base/file.h"
#include "host/mesh/check_mesh.h"
#include "host/mesh/io/gltf.h"
#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "tests/animation/animations.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

const std::string figure = MALHA_SOURCE_DIR "/scenes/meshes/figure.glb";
const std::string samples = MALHA_SOURCE_DIR "/../shared/data/animated/";

AnimationSpec looped(const std::variant<int, std::string>& clip) {
  AnimationSpec spec;
  spec.clip = clip, spec.loop = true;
  return spec;
}

GltfScene scene_in(const std::string& path) { return read_gltf_scene(path, read_whole(path)); }

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) largest = std::max(largest, distance(a[v], b[v]));
  return largest;
}

class WalkingFigure : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!has_gltf()) GTEST_SKIP() << "built without tinygltf";
    if (!std::filesystem::exists(GetParam())) GTEST_SKIP() << "no " << GetParam();
  }
};
INSTANTIATE_TEST_SUITE_P(Files, WalkingFigure,
                         testing::Values(figure, samples + "CesiumMan.glb", samples + "RiggedSimple.glb"),
                         [](const testing::TestParamInfo<std::string>& info) {
                           return std::filesystem::path(info.param).stem().string();
                         });

/// A place that the joint of a vertex holds rigidly: the vertices that follow this joint alone.
std::vector<std::vector<int>> rigid_parts(const GltfScene& scene) {
  std::vector<std::vector<int>> parts(scene.joints.size());
  for (std::size_t v = 0; v < scene.points.size(); ++v)
    if (scene.influence_begin[v + 1] == scene.influence_begin[v] + 1)
      parts[std::size_t(scene.influences[std::size_t(scene.influence_begin[v])].joint)].push_back(int(v));
  return parts;
}

TEST_P(WalkingFigure, KeepsTheLengthsOfWhatFollowsOneJoint) {
  const GltfScene scene = scene_in(GetParam());
  Scene object = animated_scene(GetParam(), looped(0));
  const auto of_file = animation_of(object);
  // The vertices of points, as the animation has them.
  Mesh mesh = read_mesh(GetParam());
  weld(mesh, 0, GetParam());
  const std::vector<int> point = points_of_vertices(mesh.vertices, int(mesh.points.size()));
  int pairs = 0;
  const std::vector<Vec3> start = sampled(*of_file, 0);
  for (const double time : {.13, .4, .77}) {
    const std::vector<Vec3> later = sampled(*of_file, time * of_file->duration());
    for (const std::vector<int>& part : rigid_parts(scene))
      for (std::size_t i = 1; i < part.size(); ++i) {
        const auto a = std::size_t(point[std::size_t(part[0])]), b = std::size_t(point[std::size_t(part[i])]);
        // Scales of joints differ from 1 by some 1e-6 in the samples.
        EXPECT_NEAR(distance(later[a], later[b]), distance(start[a], start[b]), 1e-5);
        ++pairs;
      }
  }
  EXPECT_GT(pairs, 100);
}

TEST_P(WalkingFigure, RepeatsAfterTheLengthOfItsClip) {
  const auto walk = animation_of(animated_scene(GetParam(), looped(0)));
  for (const double time : {0., .3, .61})
    EXPECT_LT(largest_difference(sampled(*walk, time), sampled(*walk, time + 3 * walk->duration())), 1e-12);
}

TEST_P(WalkingFigure, MovesContinuously) {
  // Over a thousandth of the clip no vertex moves as far as over a hundredth, even where a loop begins again.
  AnimationSpec spec = looped(GetParam() == figure ? std::variant<int, std::string>("walk") : 0);
  const auto walk = animation_of(animated_scene(GetParam(), spec));
  const double whole = walk->duration();
  if (GetParam().ends_with("RiggedSimple.glb")) GTEST_SKIP() << "a pipe of 10 m";
  double fastest = 0;
  std::vector<Vec3> before = sampled(*walk, 0);
  for (int i = 1; i <= 2000; ++i) {
    const std::vector<Vec3> now = sampled(*walk, i * whole / 1000);
    fastest = std::max(fastest, largest_difference(before, now) / (whole / 1000));
    before = now;
  }
  EXPECT_LT(fastest, 8);  // m/s: a foot that swings at a walk has some 4
  EXPECT_GT(fastest, 1);
}

/// What the file has: 49 keys at 24 a second, of which the last is the one before the first.
TEST(CesiumMan, WalksACycleOfFortyNineKeys) {
  if (!has_gltf() || !std::filesystem::exists(samples + "CesiumMan.glb")) GTEST_SKIP();
  const auto walk = animation_of(animated_scene(samples + "CesiumMan.glb", looped("Anim_0")));
  EXPECT_NEAR(walk->duration(), 49. / 24, 1e-6);
  const std::vector<Vec3> points = sampled(*walk, .5);
  double high = -1, low = 1;
  for (const Vec3& x : points) high = std::max(high, x[1]), low = std::min(low, x[1]);
  EXPECT_NEAR(high - low, 1.5, .1);  // he is 1.5 m high, with y upwards
}

class ShippedFigure : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_gltf()) GTEST_SKIP() << "built without tinygltf";
  }
};

TEST_F(ShippedFigure, IsAClosedSolidThatStandsOnTheGround) {
  Scene scene = animated_scene(figure, looped("stand"));
  scene.environment[0].sides = Sides::Solid;
  scene.bodies = {particle({0, 3, 0})};
  const Mesh mesh = build_model(scene).environment[0].mesh;  // which refuses what is open
  EXPECT_GT(mesh.points.size(), 2500u);
  EXPECT_LT(mesh.points.size(), 4000u);
  Vec3 low = mesh.points[0], high = low;
  for (const Vec3& x : mesh.points)
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
  EXPECT_NEAR(low[1], 0, .002);
  EXPECT_NEAR(high[1], 1.7, .02);
}

TEST_F(ShippedFigure, IsItsBindPoseWhereJointsAreAtRest) {
  const GltfScene scene = scene_in(figure);
  EXPECT_LT(largest_difference(read_mesh(figure).points, scene.points), 1e-6);
}

TEST_F(ShippedFigure, DressesFromTheStandAndWalksOn) {
  const auto stand = animation_of(animated_scene(figure, looped("stand")));
  AnimationSpec once;
  once.clip = "dress";
  const auto dress = animation_of(animated_scene(figure, once));
  EXPECT_DOUBLE_EQ(stand->duration(), 0);
  EXPECT_NEAR(dress->duration(), 11, 1e-6);
  EXPECT_LT(largest_difference(sampled(*stand, 0), sampled(*dress, 0)), .002);
  // From one second on it walks: every cycle of 1.1 s is like the one before, to the blend of its keys, 1/30 s apart.
  EXPECT_LT(largest_difference(sampled(*dress, 2), sampled(*dress, 2 + 3 * 1.1)), .01);
}

TEST_F(ShippedFigure, DISABLED_TimeOfASample) {
  for (const std::string& file : {figure, samples + "CesiumMan.glb"}) {
    if (!std::filesystem::exists(file)) continue;
    const auto walk =
        animation_of(animated_scene(file, looped(file == figure ? std::variant<int, std::string>("walk") : 0)));
    std::vector<Vec3> points(std::size_t(walk->vertex_count()));
    std::vector<double> times;
    for (int i = 0; i < 2000; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      walk->sample(i * .0017, points);
      times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    }
    std::ranges::nth_element(times, times.begin() + 1000);
    std::printf("%s: %d points, %.4f ms\n", std::filesystem::path(file).filename().c_str(), walk->vertex_count(),
                times[1000]);
  }
}

}  // namespace
}  // namespace malha
