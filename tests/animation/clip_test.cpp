// SPDX-License-Identifier: Apache-2.0
// Clips of glTF files against closed forms, on a strip of two bones that the test writes.
#include <gtest/gtest.h>

#include <cmath>

#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "tests/animation/animations.h"
#include "tests/animation/glb_builder.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double of_floats = 2e-7;  // the file's numbers are floats of about 1

class Clip : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_gltf()) GTEST_SKIP() << "built without tinygltf";
  }
  std::string write(const GlbBuilder& file) { return folder_.write("strip.glb", file.bytes()); }
  std::shared_ptr<const Animation> load(const GlbBuilder& file, const AnimationSpec& spec = {}) {
    return animation_of(animated_scene(write(file), spec));
  }
  TemporaryFolder folder_;
};

/// The strip with its upper joint turned by `radians` about z and moved by `moved`: a vertex at the top is carried
/// round the joint, and one in the middle is halfway between that and where it was (linear blend skinning).
std::vector<Vec3> bent_strip(double radians, const Vec3& moved = {}) {
  const double c = std::cos(radians), s = std::sin(radians);
  std::vector<Vec3> points;
  for (const double y : {0., 1., 2.})
    for (const double x : {-.5, .5}) {
      const Vec3 carried{c * x - s * (y - 1) + moved[0], 1 + s * x + c * (y - 1) + moved[1], moved[2]};
      const double share = y / 2;
      points.push_back(
          {(1 - share) * x + share * carried[0], (1 - share) * y + share * carried[1], share * carried[2]});
    }
  return points;
}

void expect_points(const std::vector<Vec3>& found, const std::vector<Vec3>& wanted, double within = of_floats) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t v = 0; v < found.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found[v][k], wanted[v][k], within) << "vertex " << v;
}

TEST_F(Clip, BendsAStripOfTwoBonesAsLinearBlendSkinningDoes) {
  for (const int weights : {kGltfFloat, kGltfShort, kGltfByte}) {
    const auto strip = load(bending_strip(120, weights));
    EXPECT_DOUBLE_EQ(strip->duration(), 1);
    // A half has the next bytes above and below it.
    const double within = weights == kGltfFloat ? of_floats : weights == kGltfByte ? 1.1 / 510 : 1.1 / 131070;
    for (const double time : {0., .25, .5, 1.})
      expect_points(sampled(*strip, time), bent_strip(time * 120 * M_PI / 180), within);
  }
}

TEST_F(Clip, TurnsTheShorterWay) {
  GlbBuilder file = two_bone_strip();
  file.json["animations"] = {{{"name", "turn"}}};
  // The second key is a turn by 60 degrees, as the quaternion of the opposite sign.
  file.channel(2, "rotation", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, 0, -.5f, -std::sqrt(.75f)});
  expect_points(sampled(*load(file), .5), bent_strip(M_PI / 6));
}

TEST_F(Clip, KeepsTheLastKeyOfAStep) {
  GlbBuilder file = two_bone_strip();
  file.json["animations"] = {{{"name", "jump"}}};
  file.channel(2, "translation", "STEP", {0, 1, 2}, {0, 1, 0, 3, 1, 0, 0, 1, 4});
  const auto strip = load(file);
  expect_points(sampled(*strip, .999), bent_strip(0));
  expect_points(sampled(*strip, 1), bent_strip(0, {3, 0, 0}));
  expect_points(sampled(*strip, 2), bent_strip(0, {0, 0, 4}));
}

TEST_F(Clip, IsLinearBetweenKeysOfTranslationAndScale) {
  GlbBuilder file = two_bone_strip();
  file.json["animations"] = {{{"name", "move"}}};
  file.channel(2, "translation", "LINEAR", {1, 3}, {0, 1, 0, 4, 1, 2});
  file.channel(1, "scale", "LINEAR", {1, 3}, {1, 1, 1, 1, 3, 1});
  const auto strip = load(file);
  EXPECT_DOUBLE_EQ(strip->duration(), 2);  // from the first key to the last
  std::vector<Vec3> wanted = bent_strip(0, {1, 0, .5});
  for (Vec3& x : wanted) x[1] *= 1.5;
  expect_points(sampled(*strip, .5), wanted, 4 * of_floats);
}

TEST_F(Clip, FollowsHermitesPolynomialThroughASplineOfItsKeys) {
  // x(t) = t^3 - t over two seconds: its tangents are -1 at 0 and 11 at 2.
  GlbBuilder file = two_bone_strip();
  file.json["animations"] = {{{"name", "spline"}}};
  file.channel(2, "translation", "CUBICSPLINE", {0, 2},
               {9, 9, 9, 0, 1, 0, -1, 0, 0,  //
                11, 0, 0, 6, 1, 0, 9, 9, 9});
  const auto strip = load(file);
  for (const double t : {.0, .3, 1., 1.7, 2.})
    expect_points(sampled(*strip, t), bent_strip(0, {t * t * t - t, 0, 0}), 4 * of_floats);
}

TEST_F(Clip, AddsMorphTargetsByTheirWeightsBeforeTheJoints) {
  GlbBuilder file = bending_strip(90);
  const int up = file.floats({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0}, "VEC3", 3);
  const int aside = file.floats({1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3", 3);
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
  file.channel(0, "weights", "LINEAR", {0, 1}, {0, 0, 2, .5f});
  const auto strip = load(file);
  const Vec3 top = sampled(*strip, 1)[4];  // (-.5, 2) + 2 (0, 1) + .5 (1, 0), turned about (0, 1) by 90 degrees
  EXPECT_NEAR(top[0], -3, 4 * of_floats);
  EXPECT_NEAR(top[1], 1, 4 * of_floats);
}

TEST_F(Clip, MovesAMeshWithoutSkinWithItsNode) {
  GlbBuilder file;
  const int points = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  file.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", points}}}}}}}};
  file.json["nodes"] = {{{"children", {1}}, {"rotation", {0, 0, std::sqrt(.5), std::sqrt(.5)}}},
                        {{"mesh", 0}, {"scale", {2, 2, 2}}, {"translation", {0, 3, 0}}}};
  file.json["animations"] = {{{"name", "fly"}}};
  file.channel(0, "translation", "LINEAR", {0, 1}, {0, 0, 0, 0, 0, 8});
  // The child is scaled, moved by 3 along y, turned by 90 degrees about z, and moved by its parent.
  expect_points(sampled(*load(file), .25), {{-3, 0, 2}, {-3, 2, 2}, {-5, 0, 2}}, 1e-6);
}

TEST_F(Clip, TurnsTheFacesOfAMirroredMeshOutwardsAgain) {
  GlbBuilder file;
  const int points = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  file.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", points}}}}}}}};
  file.json["nodes"] = {{{"mesh", 0}, {"scale", {1, 1, -1}}}};
  const Mesh mesh = read_mesh(write(file));  // a mirror of z leaves the triangle where it was, with its normal to -z
  const Quad& face = mesh.faces.at(0);
  EXPECT_LT(normal(mesh.points[std::size_t(face[0])], mesh.points[std::size_t(face[1])],
                   mesh.points[std::size_t(face[2])])[2],
            0);
}

TEST_F(Clip, ReadsStripsFansAndSeveralPrimitivesInTheirOrder) {
  GlbBuilder file;
  const int points = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3", 3);
  const auto primitive = [&](int mode) {
    return nlohmann::json{{"attributes", {{"POSITION", points}}}, {"mode", mode}};
  };
  file.json["meshes"] = {{{"primitives", {primitive(5), primitive(6)}}}};
  file.json["nodes"] = {{{"mesh", 0}}};
  const Mesh mesh = read_mesh(write(file));
  EXPECT_EQ(mesh.points.size(), 4u) << "both primitives have the same attributes, and therefore share vertices";
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, -1}, {2, 1, 3, -1}, {1, 2, 0, -1}, {2, 3, 0, -1}}));
  file.json["meshes"][0]["primitives"][1]["attributes"]["POSITION"] =
      file.floats({0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1}, "VEC3", 3);
  const Mesh two = read_mesh(write(file));
  EXPECT_EQ(two.points.size(), 8u);
  EXPECT_EQ(two.faces, (std::vector<Quad>{{0, 1, 2, -1}, {2, 1, 3, -1}, {5, 6, 4, -1}, {6, 7, 4, -1}}));
}

TEST_F(Clip, IsFoundByItsNameOrItsNumber) {
  GlbBuilder file = bending_strip(90);
  file.json["animations"].push_back({{"name", "rise"}});
  file.channel(2, "translation", "LINEAR", {0, 1}, {0, 1, 0, 0, 5, 0});
  AnimationSpec spec;
  spec.clip = "rise";
  expect_points(sampled(*load(file, spec), 1), bent_strip(0, {0, 4, 0}), 4 * of_floats);
  spec.clip = 1;
  expect_points(sampled(*load(file, spec), 1), bent_strip(0, {0, 4, 0}), 4 * of_floats);
  const std::string allowed = "; allowed: clips of " + write(file) + ": 'bend', 'rise', or their numbers from 0";
  spec.clip = "ries";
  EXPECT_EQ(refusal([&] { load(file, spec); }),
            "test.json: /environment/0/animation/clip: found \"ries\" (did you mean 'rise'?)" + allowed);
  spec.clip = 2;
  EXPECT_EQ(refusal([&] { load(file, spec); }), "test.json: /environment/0/animation/clip: found 2" + allowed);
}

TEST_F(Clip, RunsAtItsSpeedFromItsOffsetAndStaysOutsideAtItsEnds) {
  AnimationSpec spec;
  spec.speed = 2, spec.offset = .25;
  const auto strip = load(bending_strip(90), spec);
  EXPECT_DOUBLE_EQ(strip->duration(), .5);
  expect_points(sampled(*strip, .25), bent_strip(.75 * M_PI / 2));
  expect_points(sampled(*strip, -9), bent_strip(0));
  expect_points(sampled(*strip, 9), bent_strip(M_PI / 2));
}

TEST_F(Clip, RepeatsAsALoop) {
  GlbBuilder file = two_bone_strip();
  file.json["animations"] = {{{"name", "jump"}}};
  file.channel(2, "translation", "LINEAR", {0, .5f, 1}, {0, 1, 0, 2, 1, 0, 0, 1, 0});
  AnimationSpec spec;
  spec.loop = true, spec.offset = -.75;
  const auto strip = load(file, spec);
  EXPECT_DOUBLE_EQ(strip->duration(), 1);
  for (const double time : {0., 1., 7.}) expect_points(sampled(*strip, time), bent_strip(0, {1, 0, 0}));
}

TEST_F(Clip, LeadsALoopBackToItsFirstPoseInTheTimeBetweenTwoKeys) {
  AnimationSpec spec;
  spec.loop = true;
  const auto strip = load(bending_strip(90), spec);  // which ends bent; its two keys are a second apart
  EXPECT_DOUBLE_EQ(strip->duration(), 2);
  for (const auto& [time, share] : {std::pair{.25, .25}, {1., 1.}, {1.25, .75}, {2., 0.}, {5.5, .5}})
    expect_points(sampled(*strip, time), bent_strip(share * M_PI / 2));
}

TEST_F(Clip, IsTransformedAsItsObjectIs) {
  Scene scene = animated_scene(write(bending_strip(90)), {});
  scene.environment[0].transform = {{1, 2, 3}, {0, 1, 0}, 90, {1, 1, 2}};
  std::vector<Vec3> wanted = bent_strip(M_PI / 4, {});
  for (Vec3& x : wanted) x = {1 + 2 * x[2], 2 + x[1], 3 - x[0]};  // 90 degrees about y take z to x and x to -z
  expect_points(sampled(*animation_of(scene), .5), wanted, 4 * of_floats);
}

TEST_F(Clip, GivesAnObjectItsShapeAtTimeZero) {
  AnimationSpec spec;
  spec.offset = .5;
  Scene scene = animated_scene(write(bending_strip(90)), spec);
  scene.bodies = {body("dust", LatticeShape{})};
  const Model model = build_model(scene);
  expect_points(model.environment[0].mesh.points, bent_strip(M_PI / 4));
}

/// Two triangles that share the places of an edge, by vertices of their own: 2 and 3 are 1 and 0.
GlbBuilder split_sheet() {
  GlbBuilder file;
  const std::vector<float> points{0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0};
  const int corners = file.add<std::uint8_t>({0, 1, 4, 2, 3, 5}, "SCALAR", 1, kGltfByte);
  file.json["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", file.floats(points, "VEC3", 3)}}}, {"indices", corners}}}}}};
  file.json["nodes"] = {{{"mesh", 0}}};
  return file;
}

TEST_F(Clip, MayMoveVerticesOfOnePlaceTogether) {
  GlbBuilder file = split_sheet();
  const int lift = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3);
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", lift}}};
  file.json["animations"] = {{{"name", "lift"}}};
  file.channel(0, "weights", "LINEAR", {0, 1}, {0, 1});
  expect_points(sampled(*load(file), .5), {{0, 0, .5}, {0, 1, .5}, {-1, 0, .5}, {1, 0, .5}});
}

TEST_F(Clip, IsRefusedWhereVerticesOfOnePlacePart) {
  GlbBuilder file = split_sheet();
  const int lift = file.floats({0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3", 3);
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", lift}}};
  file.json["animations"] = {{{"name", "tear"}}};
  file.channel(0, "weights", "LINEAR", {0, .5f}, {0, 1});
  EXPECT_EQ(refusal([&] { load(file); }), write(file) +
                                              ": 0.5 s of clip 'tear': found vertices 1 and 2 1 m apart, which are one "
                                              "point of the shape; allowed: vertices that start in one place stay "
                                              "together");
}

TEST_F(Clip, OfAnotherFileNeedsTheVerticesOfTheShape) {
  AnimationSpec spec;
  spec.file = folder_.write("sheet.glb", [] {
    GlbBuilder file = split_sheet();
    file.json["animations"] = {{{"name", "fly"}}};
    file.channel(0, "translation", "LINEAR", {0, 1}, {0, 0, 0, 0, 0, 1});
    return file.bytes();
  }());
  const std::string strip = write(two_bone_strip());
  EXPECT_EQ(animation_of(animated_scene(strip, spec))->vertex_count(), 6);
  GlbBuilder longer = split_sheet();
  longer.json["nodes"] = {{{"mesh", 0}, {"children", {1}}}, {{"mesh", 0}}};
  const std::string shape = folder_.write("longer.glb", longer.bytes());
  EXPECT_EQ(refusal([&] { animation_of(animated_scene(shape, spec)); }),
            spec.file + ": found 6 vertices; allowed: as many as the shape of object 'walker' has, 12");
}

/// What is wrong in a file, and what is said of it after the file's name.
struct BadClip {
  std::string name, pointer, value, says;
};
void PrintTo(const BadClip& bad, std::ostream* out) { *out << bad.pointer << " = " << bad.value; }

class BadGltf : public testing::TestWithParam<BadClip> {};

TEST_P(BadGltf, IsRefused) {
  if (!has_gltf()) GTEST_SKIP() << "built without tinygltf";
  const TemporaryFolder folder;
  GlbBuilder file = bending_strip(90);
  file.json[nlohmann::json::json_pointer(GetParam().pointer)] = nlohmann::json::parse(GetParam().value);
  const std::string path = folder.write("bad.glb", file.bytes());
  const std::string refused = refusal([&] { animation_of(animated_scene(path, {})); });
  EXPECT_EQ(refused.find(path + ": " + GetParam().says), 0u) << refused;
  EXPECT_NE(refused.find("; allowed: "), std::string::npos) << refused;
}

// Accessors of the file: 0 points, 1 corners, 2 joints, 3 weights, 4 inverse bind matrices, 5 times, 6 rotations.
INSTANTIATE_TEST_SUITE_P(
    Parts, BadGltf,
    testing::Values(
        BadClip{"Version", "/asset/version", "\"1.0\"", "/asset/version: found \"1.0\""},
        BadClip{"Extension", "/extensionsRequired", R"(["KHR_draco_mesh_compression"])",
                "/extensionsRequired/0: found \"KHR_draco_mesh_compression\""},
        BadClip{"Clips", "/animations", "[]", "/animations: found no clips"},
        BadClip{"Channels", "/animations/0", R"({"name": "none", "channels": [], "samplers": []})",
                "/animations/0: found a clip that moves no node"},
        BadClip{"Interpolation", "/animations/0/samplers/0/interpolation", "\"SMOOTH\"",
                "/animations/0/samplers/0/interpolation: found \"SMOOTH\""},
        BadClip{"NodeOfAChannel", "/animations/0/channels/0/target/node", "3",
                "/animations/0/channels/0/target/node: found 3; allowed: an index below 3"},
        BadClip{"ValuesOfAChannel", "/accessors/6/count", "1", "/animations/0/samplers/0/output: found 4 numbers"},
        BadClip{"TimesOfAChannel", "/accessors/5/byteOffset", "4", "/accessors/5: found bytes up to 12"},
        BadClip{"Mode", "/meshes/0/primitives/0/mode", "1", "/meshes/0/primitives/0/mode: found 1"},
        BadClip{"Corners", "/accessors/0/count", "5", "/meshes/0/primitives/0/indices: found vertex 5"},
        BadClip{"Joints", "/skins/0/joints", "[1]",
                "/meshes/0/primitives/0/attributes/JOINTS_0: found joint 1; allowed: joints of the skin, below 1"},
        BadClip{"JointOfASkin", "/skins/0/joints", "[1, 9]", "/skins/0/joints: found 9"},
        BadClip{"BindMatrices", "/accessors/4/count", "1", "/skins/0/inverseBindMatrices: found 1"},
        BadClip{"WeightsOfFewerVertices", "/accessors/3/count", "5", "/meshes/0/primitives/0/attributes: found"},
        BadClip{"NoWeights", "/meshes/0/primitives/0/attributes", R"({"POSITION": 0, "JOINTS_0": 2})",
                "/meshes/0/primitives/0/attributes: found JOINTS_0 without WEIGHTS_0"},
        BadClip{"NoPositions", "/meshes/0/primitives/0/attributes", R"({"JOINTS_0": 2, "WEIGHTS_0": 3})",
                "/meshes/0/primitives/0/attributes: found no POSITION"},
        BadClip{"TypeOfPositions", "/meshes/0/primitives/0/attributes/POSITION", "3",
                "/accessors/3/type: found another type; allowed: VEC3"},
        BadClip{"BytesOfAnAccessor", "/accessors/0/count", "7", "/accessors/0: found bytes up to 84"},
        BadClip{"BytesOfAView", "/bufferViews/0/byteLength", "1000000", "/bufferViews/0: found bytes up to 1000000"},
        BadClip{"Stride", "/bufferViews/0/byteStride", "4", "/bufferViews/0/byteStride: found 4"},
        BadClip{"NodesInACircle", "/nodes/2/children", "[1]", "/"},
        BadClip{"NodeOfTwoParents", "/nodes/0/children", "[2]", "/nodes/1/children: found node 2"},
        BadClip{"SceneWithoutTriangles", "/scenes/0/nodes", "[1]", "/meshes: found no triangles"}),
    [](const testing::TestParamInfo<BadClip>& info) { return info.param.name; });

TEST_F(Clip, OfATruncatedFileIsRefused) {
  const std::string whole = bending_strip(90).bytes();
  for (std::size_t bytes = 0; bytes < whole.size(); bytes += 37) {
    const std::string path = folder_.write("short.glb", whole.substr(0, bytes));
    EXPECT_EQ(refusal([&] { animation_of(animated_scene(path, {})); }).find(path + ": found "), 0u) << bytes;
  }
}

TEST_F(Clip, OfARunIsWhatTheRunWroteAsFrames) {
  // malha writes a run as morph targets; read back, the sheet is where its frames were, to rounding.
  const Json scene = Json::parse(R"({
    "name": "falling", "solver": {"type": "pbd", "dt": 0.02}, "gravity": [0, -9.81, 0], "duration": 0.2,
    "bodies": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [3, 3]}}, "mass": 1,
                "constraints": [{"type": "distance"}]}],
    "outputs": {"frames": {"every": 5, "formats": ["glb"]}}})");
  run_quietly(scene, {.out = (folder_ / "run").string()});
  const auto sheet = animation_of(animated_scene((folder_ / "run" / "frames" / "run.glb").string(), {}));
  EXPECT_NEAR(sheet->duration(), .2, 1e-7);
  // 10 substeps a step: a symplectic fall of n substeps h is g h^2 n (n + 1) / 2.
  const double h = .002, fallen = 9.81 * h * h * 100 * 101 / 2;
  EXPECT_NEAR(sampled(*sheet, .2)[0][1], -fallen, 1e-6);
  EXPECT_NEAR(sampled(*sheet, .05)[0][1], -9.81 * h * h * 50 * 51 / 4, 1e-6);  // halfway between two frames
}

}  // namespace
}  // namespace malha
