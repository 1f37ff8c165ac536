// SPDX-License-Identifier: Apache-2.0
// A run as glTF, read back by tinygltf's own loader. What viewers show of it is tested in glb_viewers_test.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "host/render/picture.h"
#include "tests/output/glb_scene.h"
#include "tests/output/gltf_file.h"

namespace malha {
namespace {

namespace fs = std::filesystem;
using Indices = std::vector<std::uint32_t>;

class Glb : public testing::Test {
 protected:
  fs::path run_of(const Json& scene, std::optional<std::int64_t> steps = {}) const {
    return run_with_frames(folder_, scene, "out", steps);
  }
  TemporaryFolder folder_;
};

const std::vector<std::string> kBodies{"patchwork", "sheet of quads", "rope", "dust"};

/// Each position is within half a float of its vertex's displacement, and the rounding of doubles.
void expect_frame(const GltfFile& file, const std::vector<std::string>& bodies, int k, const std::vector<Vec3>& x) {
  std::size_t at = 0;
  for (const std::string& body : bodies) {
    const auto& middle = file.node(body).translation;
    const auto& primitive = file.mesh(body).primitives.at(0);
    const auto base = file.values(primitive.attributes.at("POSITION"));
    const auto moved = file.values(primitive.targets.at(k).at("POSITION"));
    ASSERT_EQ(moved.size(), base.size());
    for (std::size_t i = 0; i < base.size(); ++i, ++at)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(middle[c] + base[i][c] + moved[i][c], x.at(at)[c],
                    kHalfAFloat * std::fabs(moved[i][c]) + 1e-15 * (1 + std::fabs(x[at][c])))
            << body << " vertex " << i << " of frame " << k;
  }
  EXPECT_EQ(at, x.size());
}

TEST_F(Glb, HasEveryVertexOfEveryFrameInTheOrderOfTheFiles) {
  const fs::path frames = run_of(glb_scene(folder_));
  const GltfFile file(frames / "run.glb");
  EXPECT_EQ(file.values(file.mesh("patchwork").primitives[0].attributes.at("POSITION")).size(),
            patchwork().mesh.points.size())
      << "those that nothing uses too";
  for (int k = 0; k < kGlbFrames; ++k) expect_frame(file, kBodies, k, ObjOfFrame(frames, k).points);
  EXPECT_GT(std::fabs(file.values(file.mesh("rope").primitives[0].targets[24].at("POSITION"))[9][1]), 0.5)
      << "it moves";
}

TEST_F(Glb, KeepsItsDigitsFarFromTheOrigin) {
  Json scene = swinging_sheet(false, "double");
  scene["bodies"][0]["transform"]["translate"] = {1e6, 5e5, -1e6};
  scene["outputs"]["frames"] = {{"every", 5}, {"formats", {"glb", "obj"}}};
  const fs::path frames = run_of(scene);
  const GltfFile file(frames / "run.glb");
  for (int k = 0; k < 9; ++k) expect_frame(file, {"sheet"}, k, ObjOfFrame(frames, k).points);
}

TEST_F(Glb, HasTheElementsOfTheBodiesAndQuadsAsTwoTriangles) {
  const fs::path frames = run_of(glb_scene(folder_), 1);
  const GltfFile file(frames / "run.glb");
  const ObjOfFrame obj(frames, 0);
  Indices triangles, lines, loose;  // elements of all bodies, by the numbers of all
  std::uint32_t begin = 0;
  for (const std::string& body : kBodies) {
    ASSERT_EQ(file.mesh(body).primitives.size(), 1u);
    const tinygltf::Primitive& one = file.mesh(body).primitives[0];
    Indices& all = one.mode == TINYGLTF_MODE_TRIANGLES ? triangles : one.mode == TINYGLTF_MODE_LINE ? lines : loose;
    for (const std::uint32_t corner : file.indices(one)) all.push_back(begin + corner);
    begin += static_cast<std::uint32_t>(file.model.accessors[one.attributes.at("POSITION")].count);
  }
  Indices expected;
  std::size_t quads = 0;
  for (const auto& face : obj.faces) {
    quads += face.size() == 4;
    for (const std::size_t k : {0u, 1u, 2u}) expected.push_back(face[k]);
    if (face.size() == 4)
      for (const std::size_t k : {0u, 2u, 3u}) expected.push_back(face[k]);
  }
  EXPECT_GT(quads, 30u);
  EXPECT_LT(quads, obj.faces.size());
  EXPECT_EQ(triangles, expected);
  Indices ends, points;
  for (const auto& line : obj.lines) ends.insert(ends.end(), line.begin(), line.end());
  for (const auto& point : obj.loose) points.insert(points.end(), point.begin(), point.end());
  EXPECT_EQ(lines, ends);
  EXPECT_EQ(loose, points);
  EXPECT_EQ(ends.size(), 18u);
  EXPECT_EQ(points.size(), 12u);
}

// At the time of a frame the weight of its target is 1 and all others are 0; in between, both its neighbours have one.
TEST_F(Glb, ShowsOneTargetAtTheTimeOfEachFrame) {
  const GltfFile file(run_of(glb_scene(folder_)) / "run.glb");
  for (const std::string& body : kBodies) {
    const tinygltf::AnimationSampler& sampler = file.sampler(body, "weights");
    EXPECT_EQ(sampler.interpolation, "LINEAR");
    const auto times = file.values<float, 1>(sampler.input), weights = file.values<float, 1>(sampler.output);
    ASSERT_EQ(times.size(), std::size_t{kGlbFrames});
    ASSERT_EQ(weights.size(), std::size_t{kGlbFrames * kGlbFrames});
    const auto& names = file.mesh(body).extras.Get("targetNames");
    for (int k = 0; k < kGlbFrames; ++k) {
      EXPECT_FLOAT_EQ(times[k][0], static_cast<float>(k * kGlbStep));
      for (int target = 0; target < kGlbFrames; ++target) EXPECT_EQ(weights[k * kGlbFrames + target][0], k == target);
    }
    EXPECT_EQ(names.Get(12).Get<std::string>(), "frame_000012");
  }
}

TEST_F(Glb, MovesWhatMovesInTheEnvironment) {
  const GltfFile file(run_of(glb_scene(folder_)) / "run.glb");
  const auto base = file.values(file.mesh("ball").primitives.at(0).attributes.at("POSITION"));
  ASSERT_EQ(base.size(), 162u);
  const auto places = file.values(file.sampler("ball", "translation").output);
  const auto turns = file.values<float, 4>(file.sampler("ball", "rotation").output);
  for (int k = 0; k < kGlbFrames; ++k) {
    const auto [x, y, z, w] = turns[k];
    for (const auto& p : base) {
      const Vec3 start{double(p[0]) + places[0][0], double(p[1]) + places[0][1], double(p[2]) + places[0][2]};
      const Vec3 expected = on_the_ball(start, k * kGlbStep);
      // The rotation's matrix, by the books: first and second row.
      const double found[2]{(1 - 2 * (y * y + z * z)) * p[0] + 2 * (x * y - z * w) * p[1] + 2 * (x * z + y * w) * p[2],
                            2 * (x * y + z * w) * p[0] + (1 - 2 * (x * x + z * z)) * p[1] + 2 * (y * z - x * w) * p[2]};
      for (int c = 0; c < 2; ++c) ASSERT_NEAR(places[k][c] + found[c], expected[c], 1e-6) << "floats of 3 m";
    }
    double along = 0;
    for (int c = 0; k > 0 && c < 4; ++c) along += turns[k][c] * turns[k - 1][c];
    EXPECT_GT(along, k > 0 ? 0.9 : -1) << "the short way, where 500 degrees a second pass the half turn";
  }
  EXPECT_TRUE(file.node("ground").rotation.empty());
  EXPECT_THROW(file.sampler("ground", "translation"), std::runtime_error);
}

TEST_F(Glb, HasTheColoursOfThePicturesAndBothSides) {
  const GltfFile file(run_of(glb_scene(folder_), 1) / "run.glb");
  const auto expect_colour = [&](const std::string& name, const std::array<float, 3>& srgb) {
    const tinygltf::Material& material = file.model.materials.at(file.mesh(name).primitives.at(0).material);
    EXPECT_TRUE(material.doubleSided);
    for (int k = 0; k < 3; ++k) {  // from linear to sRGB, IEC 61966-2-1
      const double linear = material.pbrMetallicRoughness.baseColorFactor[k];
      EXPECT_NEAR(linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055, srgb[k], 1e-4);
    }
  };
  for (int b = 0; b < 4; ++b) expect_colour(kBodies[b], body_colour(b));
  expect_colour("ground", stone_colour());
}

TEST_F(Glb, HasNamesInWellFormedUtf8) {
  Json scene = swinging_sheet(false);
  scene["outputs"]["frames"] = {{"every", 40}, {"formats", {"glb"}}};
  Scene foreign = parsed(scene);
  foreign.bodies[0].name = "Stoff \xc3\xbc \xff";
  run(
      foreign, {.threads = 1}, {.out = (folder_ / "out").string()}, [](const Progress&) {}, std::atomic<bool>{false});
  EXPECT_EQ(GltfFile(folder_ / "out/frames/run.glb").model.nodes.at(0).name, "Stoff \xc3\xbc ?");
}

TEST_F(Glb, HasAPrimitiveForEachKindOfElementOfABody) {
  FrameWriter writer(folder_ / "", {"glb"}, of_all_kinds());
  writer.write(0, of_all_kinds().rest, std::vector<Vec3>(9)), writer.finish();
  const GltfFile file(folder_ / "run.glb");
  const auto& primitives = file.mesh("all").primitives;
  ASSERT_EQ(primitives.size(), 3u);
  EXPECT_EQ(file.indices(primitives[0]), (Indices{0, 1, 2, 0, 2, 3, 1, 4, 2}));
  EXPECT_EQ(file.indices(primitives[1]), (Indices{5, 6}));
  EXPECT_EQ(file.indices(primitives[2]), (Indices{7}));
  const int modes[]{TINYGLTF_MODE_TRIANGLES, TINYGLTF_MODE_LINE, TINYGLTF_MODE_POINTS};
  for (int k = 0; k < 3; ++k) EXPECT_EQ(primitives[k].mode, modes[k]);
}

TEST_F(Glb, HasTimesThatGrowWhereFloatsCannotTellThemApart) {
  FrameWriter writer(folder_ / "", {"glb"}, of_all_kinds());
  for (const double time : {1e9, 1e9 + 0.01, 1e9 + 0.02}) writer.write(time, of_all_kinds().rest, std::vector<Vec3>(9));
  writer.finish();
  const GltfFile file(folder_ / "run.glb");
  const auto times = file.values<float, 1>(file.sampler("all", "weights").input);
  EXPECT_EQ(times[0][0], 1e9f);
  EXPECT_LT(times[0], times[1]);
  EXPECT_LT(times[1], times[2]);
}

}  // namespace
}  // namespace malha
