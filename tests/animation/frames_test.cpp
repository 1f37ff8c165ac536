// SPDX-License-Identifier: Apache-2.0
// Animations of frames: point caches, and series of mesh files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "host/output/frame_formats.h"
#include "tests/animation/animations.h"
#include "tests/refusal.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double rate = 4;  // frames a second

AnimationSpec frames_from(const std::string& frames) {
  AnimationSpec spec;
  spec.frames = frames, spec.frames_per_second = rate;
  return spec;
}

/// A triangle whose third corner is at the height of a frame. Its numbers are floats.
std::vector<Vec3> triangle_at(double height) { return {{0, 0, 0}, {1, 0, 0}, {0, height, .25}}; }

std::string obj_at(double height, const std::string& face = "1 2 3") {
  std::string text;
  for (const Vec3& x : triangle_at(height))
    text += "v " + std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]) + "\n";
  return text + "f " + face + "\n";
}

class PointCache : public testing::Test {
 protected:
  /// A point cache by malha's own writer, with the triangle at these heights.
  std::string write(const std::vector<double>& heights) {
    FrameTopology topology;
    topology.polygons = polygons_of({{0, 1, 2, -1}}), topology.rest = triangle_at(1);
    topology.meshes = {{"sheet", 0, 0, 0}};
    const auto format = make_pc2((folder_ / "rest.obj").parent_path(), topology, 0);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const std::vector<Vec3> points = triangle_at(heights[i]);
      format->write({static_cast<int>(i), 0, points, points});
    }
    return (folder_ / "points_sheet.pc2").string();
  }
  /// The cache with one of its header's or samples' numbers replaced.
  template <class T>
  std::string changed(std::size_t byte, T value) {
    std::string bytes = bytes_of(folder_ / "points_sheet.pc2");
    std::memcpy(bytes.data() + byte, &value, sizeof value);
    return folder_.write("changed.pc2", bytes);
  }
  Scene scene(const std::string& cache) {
    return animated_scene(folder_.write("shape.obj", obj_at(1)), frames_from(cache));
  }
  std::string refused(const std::string& cache) {
    return refusal([&] { animation_of(scene(cache)); });
  }
  TemporaryFolder folder_;
};

TEST_F(PointCache, IsReadAsMalhaWritesIt) {
  const auto triangle = animation_of(scene(write({1, 2, 4})));
  EXPECT_DOUBLE_EQ(triangle->duration(), 2 / rate);
  for (const auto& [frame, height] : {std::pair{0., 1.}, {1., 2.}, {1.5, 3.}, {2., 4.}, {9., 4.}, {-1., 1.}})
    EXPECT_EQ(sampled(*triangle, frame / rate), triangle_at(height)) << frame;
}

TEST_F(PointCache, BlendsTheLastFrameOfALoopIntoTheFirst) {
  Scene looped = scene(write({1, 2, 4}));
  looped.environment[0].animation->loop = true;
  const auto triangle = animation_of(looped);
  EXPECT_DOUBLE_EQ(triangle->duration(), 3 / rate);
  for (const double turns : {0., 1., 5.}) {
    EXPECT_EQ(sampled(*triangle, (2.5 + 3 * turns) / rate), triangle_at(2.5));
    EXPECT_EQ(sampled(*triangle, 3 * turns / rate), triangle_at(1));
  }
  // It is continuous where it begins again: the corner falls by 3 m in a frame of 1 / rate.
  EXPECT_NEAR(sampled(*triangle, (3 - 1e-9) / rate)[2][1], sampled(*triangle, 3 / rate)[2][1], 4e-9);
}

TEST_F(PointCache, HasItsOwnFramesForEachSample) {
  write({1, 2, 4});
  EXPECT_DOUBLE_EQ(animation_of(scene(changed(24, 2.f)))->duration(), 2 * 2 / rate);
}

TEST_F(PointCache, IsRefusedWhereItIsNone) {
  const std::string cache = write({1, 2, 4});
  const std::string other = (folder_ / "changed.pc2").string();
  EXPECT_EQ(refused(changed(0, 'p')), other + ": byte 0: found no header of a point cache; allowed: POINTCACHE2");
  EXPECT_EQ(refused(changed(12, 2)), other + ": byte 12: found version 2; allowed: 1");
  EXPECT_EQ(refused(changed(16, 4)), other + ": found 140 bytes; allowed: 176 for 3 samples of 4 points");
  EXPECT_EQ(refused(changed(16, 2)),
            other + ": found 2 vertices; allowed: as many as the shape of object 'walker' has, 3");
  EXPECT_EQ(refused(changed(16, 0)), other + ": byte 16: found 0 points; allowed: one or more");
  EXPECT_EQ(refused(changed(24, 0.f)),
            other + ": byte 24: found a number of frames for each sample that is not above 0; allowed: > 0");
  EXPECT_EQ(refused(changed(28, 0)), other + ": byte 28: found 0 samples; allowed: one or more");
  EXPECT_EQ(refused(changed(28, 2000000000)).find(other + ": found 140 bytes; allowed: 72000000032 for"), 0u);
  EXPECT_EQ(refused(changed(32 + 36 + 12, std::numeric_limits<float>::infinity())),
            other + ": frame 1: found inf at vertex 1; allowed: numbers up to 1e18");
  EXPECT_EQ(refused(changed(32 + 36 + 12, 1e30f)),
            other + ": frame 1: found 1e+30 at vertex 1; allowed: numbers up to 1e18");
  EXPECT_EQ(refused(folder_.write("none.pc2", "")),
            (folder_ / "none.pc2").string() + ": byte 0: found no header of a point cache; allowed: POINTCACHE2");
  EXPECT_EQ(refused((folder_ / "missing.pc2").string()),
            (folder_ / "missing.pc2").string() + ": found no file; allowed: a readable PC2 file");
}

class Series : public testing::Test {
 protected:
  void write(const std::string& name, double height) { folder_.write(name, obj_at(height)); }
  Scene scene(const std::string& frames) {
    return animated_scene(folder_.write("shape.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 .25\n3 0 1 2\n"),
                          frames_from((folder_ / frames).string()));
  }
  std::string refused(const std::string& frames) {
    const std::string whole = refusal([&] { animation_of(scene(frames)); });
    const std::string folder = (folder_ / "").string();
    return whole.starts_with(folder) ? whole.substr(folder.size()) : whole;
  }
  TemporaryFolder folder_;
};

TEST_F(Series, IsInTheOrderOfItsNumbers) {
  for (const int i : {8, 9, 10, 11}) write("walk_" + std::to_string(i) + ".obj", i - 7);
  write("walk_.obj", 99), write("walk_8.obj.old", 99), write("walk_old.obj", 99);  // not of the series
  const auto triangle = animation_of(scene("walk_*.obj"));
  EXPECT_DOUBLE_EQ(triangle->duration(), 3 / rate);
  for (const double frame : {0., 1.5, 3.}) EXPECT_EQ(sampled(*triangle, frame / rate), triangle_at(1 + frame));
}

TEST_F(Series, MayBeAFolder) {
  std::filesystem::create_directory(folder_ / "frames");
  for (const int i : {0, 10, 20}) write("frames/f" + std::to_string(i) + ".obj", 1 + i / 10);
  write("frames/read.me", 0);
  EXPECT_EQ(sampled(*animation_of(scene("frames")), 2 / rate), triangle_at(3));
}

TEST_F(Series, IsRefusedWhereItIsNoSeries) {
  EXPECT_EQ(refused("walk_*.obj"), "walk_*.obj: found no frames; allowed: OBJ or PLY files with a number each");
  EXPECT_EQ(refused("*_*.obj"), "*_*.obj: found several stars; allowed: one '*' in the name, for the number");
  EXPECT_EQ(refused("walk"), "walk: found no folder; allowed: a folder, or a pattern such as \"walk_*.ply\"");
  for (const int i : {1, 2, 4}) write("walk_" + std::to_string(i) + ".obj", i);
  EXPECT_EQ(refused("walk_*.obj"), "walk_*.obj: found no frame 3 between 2 and 4; allowed: numbers at equal distances");
  write("walk_02.obj", 2);
  EXPECT_EQ(refused("walk_*.obj"), "walk_*.obj: found two frames 2; allowed: one file for each number");
}

TEST_F(Series, IsRefusedWhereItsFramesAreOtherMeshes) {
  write("walk_0.obj", 1);
  folder_.write("walk_1.obj", obj_at(2, "1 3 2"));
  EXPECT_EQ(refused("walk_*.obj"), "walk_1.obj: face 0: found other vertices; allowed: those of the frame before");
  folder_.write("walk_1.obj", obj_at(2) + "f 3 2 1\n");
  EXPECT_EQ(refused("walk_*.obj"), "walk_1.obj: found 2 faces; allowed: 1, as in the frame before");
  folder_.write("walk_1.obj", "v 0 0 0\n" + obj_at(2));
  EXPECT_EQ(refused("walk_*.obj"), "walk_1.obj: found 4 vertices; allowed: 3, as in the frame before");
  folder_.write("walk_0.obj", obj_at(2, "1 3 2"));
  EXPECT_EQ(refused("walk_*.obj"),
            "walk_0.obj: found other faces than those of the shape; allowed: the same vertices and faces");
}

TEST_F(Series, IsRefusedWhereWeldedVerticesPart) {
  // Two triangles whose shared edge has vertices of its own in each.
  const auto sheet = [](const std::string& third) {
    return "v 0 0 0\nv 0 1 0\nv 0 0 0\nv " + third + "\nv -1 0 0\nv 1 0 0\nf 1 2 5\nf 4 3 6\n";
  };
  folder_.write("walk_0.obj", sheet("0 1 0")), folder_.write("walk_1.obj", sheet("0 1 0.002"));
  const Scene scene =
      animated_scene(folder_.write("shape.obj", sheet("0 1 0")), frames_from((folder_ / "walk_*.obj").string()));
  EXPECT_EQ(refusal([&] { animation_of(scene); }),
            (folder_ / "walk_*.obj").string() +
                ": frame 1: found vertices 1 and 3 0.002 m apart, which are one point of the shape; allowed: vertices "
                "that start in one place stay together");
}

}  // namespace
}  // namespace malha
