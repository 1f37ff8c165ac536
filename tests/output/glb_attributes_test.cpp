// SPDX-License-Identifier: Apache-2.0
// What mesh files say of their faces besides their places, in glTF.
#include <set>

#include "host/attachments/object_motion.h"
#include "host/model/model.h"
#include "tests/output/garment.h"
#include "tests/output/gltf_file.h"

namespace malha {
namespace {

class GlbAttributes : public GarmentRun {};

TEST_F(GlbAttributes, AreNodesWithTextureCoordinatesAndMaterialsInGltf) {
  const GltfFile file(run({"glb"}) / "run.glb");
  const Polygons polygons = read_file_mesh(garment_, {}, Attributes::All).polygons;
  const tinygltf::Mesh& cape = file.mesh("Cape of wool");
  EXPECT_EQ(file.mesh("Hood").primitives.size(), 1u);
  ASSERT_EQ(cape.primitives.size(), 2u) << "one a material";
  std::vector<std::string> materials;
  for (const auto& one : cape.primitives) materials.push_back(file.model.materials.at(one.material).name);
  EXPECT_EQ(materials, (std::vector<std::string>{"Wool red", "lining"}));
  const tinygltf::Material& wool = file.model.materials.at(cape.primitives[0].material);
  const tinygltf::Texture& texture = file.model.textures.at(wool.pbrMetallicRoughness.baseColorTexture.index);
  EXPECT_EQ(file.model.images.at(texture.source).mimeType, "image/png");

  const auto uv = file.values<float, 2>(cape.primitives[0].attributes.at("TEXCOORD_0"));
  ASSERT_EQ(uv.size(), 10u) << "8 vertices, and 2 of them at the seam a second time";
  // A triangle's corner has the texture coordinates that the file gives to the vertex in that polygon.
  std::set<std::array<float, 3>> expected, found;  // vertex, u, v (counted from above)
  for (std::size_t f = 0; f < 3; ++f)
    for (int c = polygons.begin[f]; c < polygons.begin[f + 1]; ++c) {
      const auto [u, v] = uv_at(polygons, c);
      expected.insert({static_cast<float>(polygons.corners[static_cast<std::size_t>(c)]), static_cast<float>(u),
                       static_cast<float>(1 - v)});
    }
  const auto start = file.values(cape.primitives[0].attributes.at("POSITION"));
  for (const auto& primitive : cape.primitives)
    for (const std::uint32_t corner : file.indices(primitive)) {
      // Copies at the seam lie where vertices 1 and 2 do.
      std::size_t vertex = corner;
      for (std::size_t v = 0; v < 8 && corner >= 8; ++v)
        if (start[v] == start[corner]) vertex = v;
      ASSERT_LT(vertex, 8u);
      found.insert({static_cast<float>(vertex), uv[corner][0], uv[corner][1]});
      for (const auto& target : cape.primitives[0].targets) {
        const auto moved = file.values(target.at("POSITION"));
        EXPECT_EQ(moved[corner], moved[vertex]) << "a copy moves as its vertex";
      }
    }
  EXPECT_EQ(found, expected);
}

TEST_F(GlbAttributes, OfGltfComeBackInGltf) {
  const std::string first = (run({"glb"}) / "run.glb").string();
  std::filesystem::copy(first, folder_ / "garment.glb");
  scene_["bodies"][0]["shape"] = {{"mesh", (folder_ / "garment.glb").string()}};
  const std::filesystem::path frames = run({"glb", "obj"});
  const GltfFile before(folder_ / "garment.glb"), after(frames / "run.glb");
  for (const char* name : {"Cape of wool", "Hood"}) {
    const tinygltf::Mesh &one = before.mesh(name), &other = after.mesh(name);
    ASSERT_EQ(one.primitives.size(), other.primitives.size());
    for (std::size_t p = 0; p < one.primitives.size(); ++p) {
      EXPECT_EQ(before.indices(one.primitives[p]), after.indices(other.primitives[p]));
      const auto uv = [p](const GltfFile& file, const tinygltf::Mesh& mesh) {
        const auto& attributes = mesh.primitives[p].attributes;  // the hood has no texture coordinates
        const auto of = attributes.find("TEXCOORD_0");
        return of == attributes.end() ? std::vector<std::array<float, 2>>() : file.values<float, 2>(of->second);
      };
      EXPECT_EQ(uv(before, one), uv(after, other));
      const auto material = [p](const GltfFile& file, const tinygltf::Mesh& mesh) {
        return file.model.materials.at(static_cast<std::size_t>(mesh.primitives[p].material));
      };
      EXPECT_EQ(material(before, one).name, material(after, other).name);
      EXPECT_EQ(material(before, one).pbrMetallicRoughness.baseColorFactor,
                material(after, other).pbrMetallicRoughness.baseColorFactor);
    }
  }
  const auto picture_in = [](const GltfFile& file) {
    const tinygltf::BufferView& view =
        file.model.bufferViews.at(static_cast<std::size_t>(file.model.images.at(0).bufferView));
    const auto* begin = reinterpret_cast<const char*>(file.model.buffers[0].data.data()) + view.byteOffset;
    return std::string(begin, view.byteLength);
  };
  EXPECT_EQ(picture_in(after), kPicture);
  const FileMesh obj = read_file_mesh((frames / "frame_000000.obj").string(), {}, Attributes::All);
  EXPECT_EQ(obj.polygons.objects, (std::vector<std::string>{"Cape of wool", "Hood"}));
  EXPECT_EQ(uv_at(obj.polygons, 1), (std::array{0.5, 0.0})) << "v counts from below again";
}

TEST_F(GlbAttributes, OfARunMoveAnObjectByItsClip) {
  const std::filesystem::path frames = run({"glb", "obj"});
  std::filesystem::copy(frames / "run.glb", folder_ / "run.glb");
  scene_["environment"] = {{{"name", "hood"},
                            {"shape", {{"mesh", (folder_ / "run.glb").string()}, {"object", "Hood"}}},
                            {"sides", "two_sided"},
                            {"animation", Json::object()}}};
  scene_["bodies"][0]["transform"] = {{"translate", {0, 0, 50}}};
  const Simulation simulation(parsed(scene_), {.threads = 1});
  const std::vector<Vec3> hood = points_at(simulation.model().environment.at(0), 0.08);
  const Mesh last = read_mesh((frames / "frame_000004.obj").string(), {"Hood", ""});
  ASSERT_EQ(hood.size(), 3u);
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(hood[v][k], last.points[v][k], 1e-6) << "floats of 3 m, three of which are added";
}

}  // namespace
}  // namespace malha
