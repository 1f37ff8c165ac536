// SPDX-License-Identifier: Apache-2.0
// What mesh files say of their faces besides their places goes through a run into the frames of every format: names of
// objects, groups and materials, texture coordinates with seams, polygons, and the order of vertices.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <regex>
#include <sstream>

#include "host/attachments/object_motion.h"
#include "host/output/frame_vertices.h"
#include "host/output/materials.h"
#include "tests/output/garment.h"
#include "tests/refusal.h"

namespace malha {
namespace {

namespace fs = std::filesystem;

class MeshAttributes : public GarmentRun {};

/// The same polygons, texture coordinates, objects and materials, and places of float.
void expect_same_attributes(const FileMesh& found, const FileMesh& expected, const std::vector<Vec3>& places) {
  EXPECT_EQ(corner_lists_of(found.polygons), corner_lists_of(expected.polygons));
  for (int c = 0; c < static_cast<int>(expected.polygons.corners.size()); ++c)
    EXPECT_EQ(uv_at(found.polygons, c), uv_at(expected.polygons, c)) << "corner " << c;
  EXPECT_EQ(named(found.polygons.objects, found.polygons.object),
            named(expected.polygons.objects, expected.polygons.object));
  EXPECT_EQ(named(found.polygons.materials, found.polygons.material),
            named(expected.polygons.materials, expected.polygons.material));
  EXPECT_EQ(named(found.polygons.groups, found.polygons.group),
            (std::vector<std::string>{"back", "side", "side", "side"}))
      << "a group holds over the next object, in the file and in the frames";
  ASSERT_EQ(found.mesh.points.size(), places.size());
  for (std::size_t v = 0; v < places.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(static_cast<float>(found.mesh.points[v][k]), static_cast<float>(places[v][k])) << "vertex " << v;
}

TEST_F(MeshAttributes, ComeBackInObjFramesWithTheOrderOfVertices) {
  const fs::path frames = run({"obj", "pc2"});
  const FileMesh expected = read_file_mesh(garment_, {}, Attributes::All);
  for (const char* name : {"frame_000004.obj", "rest.obj"}) {
    const FileMesh found = read_file_mesh((frames / name).string(), {}, Attributes::All);
    expect_same_attributes(found, expected, name[0] == 'r' ? expected.mesh.points : places());
    EXPECT_EQ(found.polygons.material_files, std::vector<std::string>{kMaterialFile});
  }
  EXPECT_GT(std::abs(places()[6][1] - 1), 1e-3) << "it has moved";
}

TEST_F(MeshAttributes, OfMaterialsComeBackWithThePathsOfTheirPictures) {
  const fs::path frames = run({"obj"});
  const std::string text = read_whole(frames / kMaterialFile);
  EXPECT_NE(text.find("newmtl Wool red\nKd 0.8 0.1 0.05\nmap_Kd -s 2 2 1 ../../pictures/wo ol.png\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("newmtl lining\nKd 0.2 0.3 0.4\nd 0.5\n"), std::string::npos) << text;
  const MaterialLook look = look_of({"any", (frames / "frame_000000.obj").string(), "Wool red", 0, {kMaterialFile}});
  EXPECT_EQ(look.colour, (std::array{0.8, 0.1, 0.05}));
  EXPECT_EQ(read_whole(look.picture), kPicture);
}

TEST_F(MeshAttributes, OfTwoFilesWithOneNameOfAMaterialStayApart) {
  fs::create_directory(folder_ / "other");
  folder_.write("other/garment.obj", kGarment), folder_.write("other/cloth of two.mtl", "newmtl lining\nKd 1 1 1\n");
  scene_["bodies"].push_back(scene_["bodies"][0]);
  scene_["bodies"][1]["name"] = "other", scene_["bodies"][1]["shape"]["mesh"] = (folder_ / "other/garment.obj");
  const fs::path frames = run({"obj"});
  const std::string text = read_whole(frames / kMaterialFile);
  EXPECT_NE(text.find("newmtl lining\nKd 0.2 0.3 0.4"), std::string::npos) << text;
  EXPECT_NE(text.find("newmtl lining.001\nKd 1 1 1"), std::string::npos) << text;
  const FileMesh found = read_file_mesh((frames / "frame_000000.obj").string(), {}, Attributes::All);
  EXPECT_EQ(found.polygons.objects, (std::vector<std::string>{"Cape of wool", "Hood", "Cape of wool.001", "Hood.001"}));
}

TEST_F(MeshAttributes, ArePointCachesOfEachObject) {
  const fs::path frames = run({"pc2"});
  const std::vector<Vec3> x = places();
  std::size_t vertex = 0;
  for (const auto& [name, count] : {std::pair{"points_Cape of wool.pc2", 8}, {"points_Hood.pc2", 3}}) {
    const std::string bytes = read_whole(frames / name);
    std::int32_t points = 0, samples = 0;
    std::memcpy(&points, bytes.data() + 16, 4), std::memcpy(&samples, bytes.data() + 28, 4);
    EXPECT_EQ(points, count);
    ASSERT_EQ(samples, 5);
    for (int v = 0; v < count; ++v, ++vertex) {
      std::array<float, 3> at{};
      std::memcpy(&at, bytes.data() + 32 + 12 * (4 * count + v), 12);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(at[k], static_cast<float>(x[vertex][k]));
    }
  }
}

TEST_F(MeshAttributes, AreListsOfPolygonsInPly) {
  const fs::path frames = run({"ply"});
  const std::string bytes = read_whole(frames / "frame_000004.ply");
  const std::size_t end = bytes.find("end_header\n");
  const std::string header = bytes.substr(0, end);
  for (const char* line :
       {"comment object 0 Cape of wool\n", "comment object 1 Hood\n", "comment group 1 side\n",
        "comment material 0 Wool red\n", "comment material 1 lining\n", "element face 4\n",
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int object\n"
        "property int group\nproperty int material\n"})
    EXPECT_NE(header.find(line), std::string::npos) << line << " is not in\n" << header;
  const FileMesh expected = read_file_mesh(garment_, {}, Attributes::All);
  const Polygons& polygons = expected.polygons;
  std::size_t at = end + 11 + 11 * 24;
  const auto next = [&](auto value) {
    std::memcpy(&value, bytes.data() + at, sizeof value), at += sizeof value;
    return value;
  };
  for (std::size_t f = 0; f < polygons.count(); ++f) {
    const auto corners = polygons.corners_of(f);
    ASSERT_EQ(next(std::uint8_t{}), corners.size());
    for (const int v : corners) EXPECT_EQ(next(std::int32_t{}), v);
    ASSERT_EQ(next(std::uint8_t{}), 2 * corners.size());
    for (int c = polygons.begin[f]; c < polygons.begin[f + 1]; ++c)
      for (const double x :
           polygons.corner_uv[static_cast<std::size_t>(c)] < 0 ? std::array{0.0, 0.0} : uv_at(polygons, c))
        EXPECT_EQ(next(0.0f), static_cast<float>(x));
    EXPECT_EQ(next(std::int32_t{}), f < 3 ? 0 : 1) << "object";
    EXPECT_EQ(next(std::int32_t{}), f < 1 ? 0 : 1) << "group";
    EXPECT_EQ(next(std::int32_t{}), f == 1 || f == 2 ? 1 : 0) << "material";
  }
  EXPECT_EQ(at, bytes.size());
  const Mesh read_back = read_mesh((frames / "frame_000004.ply").string());
  EXPECT_EQ(read_back.points.size(), 11u) << "malha reads it too";
}

/// Numbers in parentheses and brackets after a key of a USD text.
std::vector<double> numbers_after(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key);
  EXPECT_NE(at, std::string::npos) << key << " is not in\n" << text;
  std::vector<double> all;
  if (at == std::string::npos) return all;
  const std::string list = text.substr(at + key.size(), text.find('\n', at) - at - key.size());
  static const std::regex number("-?[0-9.]+(e[-+]?[0-9]+)?");
  for (auto one = std::sregex_iterator(list.begin(), list.end(), number); one != std::sregex_iterator(); ++one)
    all.push_back(std::stod(one->str()));
  return all;
}

TEST_F(MeshAttributes, AreMeshesWithTimeSamplesInUsd) {
  const std::string text = read_whole(run({"usda"}) / "run.usda");
  EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
  EXPECT_EQ(std::ranges::count(text, '{'), std::ranges::count(text, '}'));
  const std::size_t cape = text.find("def Mesh \"Cape_of_wool\""), hood = text.find("def Mesh \"Hood\"");
  ASSERT_LT(cape, hood);
  ASSERT_NE(hood, std::string::npos);
  const std::string mesh = text.substr(cape, hood - cape);
  EXPECT_NE(mesh.find("string name = \"Cape of wool\""), std::string::npos);
  EXPECT_EQ(numbers_after(mesh, "faceVertexCounts = "), (std::vector<double>{5, 3, 3}));
  EXPECT_EQ(numbers_after(mesh, "faceVertexIndices = "), (std::vector<double>{0, 1, 2, 3, 4, 2, 1, 5, 2, 5, 6}));
  const Polygons polygons = read_file_mesh(garment_, {}, Attributes::All).polygons;
  const std::vector<double> uv = numbers_after(mesh, "primvars:st = "), index = numbers_after(mesh, "st:indices = ");
  ASSERT_EQ(index.size(), 11u);
  for (int c = 0; c < 11; ++c)
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_EQ(static_cast<float>(uv[2 * static_cast<std::size_t>(index[static_cast<std::size_t>(c)]) + k]),
                static_cast<float>(uv_at(polygons, c)[k]));
  EXPECT_NE(mesh.find("rel material:binding = </run/Materials/Wool_red>"), std::string::npos);
  EXPECT_NE(text.find("asset inputs:file = @../../pictures/wo ol.png@"), std::string::npos) << text;
  const std::vector<Vec3> x = places();
  const std::string samples = mesh.substr(mesh.find("points.timeSamples"));
  const std::vector<double> at = numbers_after(samples, "      4: ");
  ASSERT_EQ(at.size(), 3 * 8u);
  for (std::size_t i = 0; i < at.size(); ++i)
    EXPECT_EQ(static_cast<float>(at[i]), static_cast<float>(x[i / 3][i % 3])) << "number " << i;
  EXPECT_EQ(numbers_after(text, "timeCodesPerSecond = "), std::vector<double>{50}) << "a frame each 0.02 s";
}

TEST_F(MeshAttributes, StayOnFacesThatTear) {
  // A strip of quads whose texture coordinates are their places, pulled until it tears.
  std::string text = "o Strip\nusemtl tape\n";
  for (int i = 0; i <= 8; ++i)
    for (int j = 0; j <= 1; ++j) {
      const std::string x = std::to_string(0.25 * i), y = std::to_string(0.25 * j);
      text += "v " + x + " " + y + " 0\nvt " + x + " " + y + "\n";
    }
  for (int i = 0; i < 8; ++i) {
    text += "f";
    for (const int v : {2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2})
      text += " " + std::to_string(v) + "/" + std::to_string(v);
    text += "\n";
  }
  Json& body = scene_["bodies"][0];
  body["shape"] = {{"mesh", folder_.write("strip.obj", text)}};
  body["pins"] = {{{"particles", {0, 1}}},
                  {{"particles", {16, 17}}, {"motion", {{{"time", 0}}, {{"time", 0.05}, {"translate", {2, 0, 0}}}}}}};
  body["tear"] = {{"strain", 0.2}};
  const fs::path frames = run({"obj"});
  const FileMesh torn = read_file_mesh((frames / "frame_000004.obj").string(), {}, Attributes::All);
  EXPECT_GT(torn.mesh.points.size(), 18u) << "it has torn";
  ASSERT_EQ(torn.polygons.count(), 8u);
  for (int f = 0; f < 8; ++f)
    for (int k = 0; k < 4; ++k) {
      const double u = 0.25 * (f + (k == 1 || k == 2)), v = 0.25 * (k > 1);
      EXPECT_EQ(uv_at(torn.polygons, 4 * f + k), (std::array{u, v})) << "corner " << k << " of face " << f;
    }
  EXPECT_EQ(named(torn.polygons.materials, torn.polygons.material), std::vector<std::string>(8, "tape"));
}

TEST_F(MeshAttributes, NameTheObjectOrGroupThatABodyIs) {
  const auto mesh = [this](const MeshPart& part) { return read_mesh(garment_, part); };
  const Mesh cape = mesh({"Cape of wool", ""}), hood = mesh({"Hood", ""}), side = mesh({"", "side"});
  EXPECT_EQ(cape.points.size(), 8u) << "with the vertex in its part of the file that nothing uses";
  EXPECT_EQ(hood.points, (std::vector<Vec3>{{0, 2, 0}, {1, 2, 0}, {0, 3, 0.2}}));
  EXPECT_EQ(hood.faces, (std::vector<Quad>{{0, 1, 2, -1}}));
  EXPECT_EQ(side.points.size(), 7u) << "vertices that the group uses";
  EXPECT_EQ(mesh({"Cape of wool", "side"}).faces, (std::vector<Quad>{{1, 0, 2, -1}, {1, 2, 3, -1}}));

  scene_["bodies"][0]["shape"]["object"] = "Hood";
  const Simulation simulation(parsed(scene_), {.threads = 1});
  EXPECT_EQ(simulation.positions().size(), 3u);
  EXPECT_EQ(parse_scene(to_json(parsed(scene_)), "again", "").bodies.at(0).shape.index(), 0u);
  const Scene again = parse_scene(to_json(parsed(scene_)), "again", "");
  EXPECT_EQ(std::get<MeshFile>(again.bodies[0].shape).part.object, "Hood") << "it is written as it is read";
}

/// The garment with the hood k times as large and k m higher.
std::string garment_with_hood(double k) {
  std::string text = kGarment;
  const std::string hood = "v 0 2 0\nv 1 2 0\nv 0 3 0.2\n";
  std::ostringstream moved;
  for (const Vec3& x : {Vec3{0, 2, 0}, {1, 2, 0}, {0, 3, 0.2}})
    moved << "v " << k * x[0] << " " << k * x[1] + k << " " << k * x[2] << "\n";
  return text.replace(text.find(hood), hood.size(), moved.str());
}

TEST_F(MeshAttributes, NameThePartOfTheFilesOfRestShapeAndAnimationToo) {
  Json& body = scene_["bodies"][0];
  body["shape"]["object"] = "Hood", body["rest"] = {{"mesh", folder_.write("rest.obj", garment_with_hood(2))}};
  fs::create_directory(folder_ / "series");
  for (int k = 1; k <= 3; ++k) folder_.write("series/hood" + std::to_string(k) + ".obj", garment_with_hood(k));
  scene_["environment"] = {{{"name", "hood"},
                            {"shape", {{"mesh", garment_}, {"object", "Hood"}}},
                            {"sides", "two_sided"},
                            {"transform", {{"translate", {0, 0, 50}}}},
                            {"animation", {{"frames", (folder_ / "series").string()}, {"frames_per_second", 10}}}}};
  const Simulation simulation(parsed(scene_), {.threads = 1});
  EXPECT_NEAR(simulation.measure().strain_max, 0.5, 1e-6) << "it starts at half its size at rest";
  const EnvironmentMesh& hood = simulation.model().environment.at(0);
  EXPECT_EQ(points_at(hood, 0.2), (std::vector<Vec3>{{0, 9, 50}, {3, 9, 50}, {0, 12, double{0.6f} + 50}}));
}

TEST_F(MeshAttributes, OfPartsThatAreNotThereAreRefusedWithThoseThatAre) {
  const std::string said = refusal([&] { read_mesh(garment_, {"Hod", ""}); });
  EXPECT_NE(said.find("did you mean 'Hood'?"), std::string::npos) << said;
  EXPECT_NE(said.find("Cape of wool, Hood"), std::string::npos) << said;
  EXPECT_NE(refusal([&] { read_mesh(garment_, {"", "front"}); }).find("back, side"), std::string::npos);
  const std::string off = folder_.write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_NE(refusal([&] { read_mesh(off, {"Hood", ""}); }).find(".obj, .glb or .gltf"), std::string::npos);
  scene_["bodies"][0]["shape"] = {{"grid", {{"size", {1, 1}}, {"cells", {2, 2}}}}, {"object", "Hood"}};
  EXPECT_NE(refusal([&] { parsed(scene_); }).find("/bodies/0/shape/object"), std::string::npos);
}

TEST_F(MeshAttributes, OfAFileThatHasChangedSinceAreRefused) {
  scene_["outputs"]["frames"] = {{"every", 1}, {"formats", {"obj"}}};
  const Simulation simulation(parsed(scene_), {.threads = 1});
  folder_.write("garment.obj", std::string(kGarment) + "v 7 7 7\n");
  const FrameVertices vertices(simulation.model().render_mesh);
  const std::string said = refusal([&] { vertices.topology(simulation.model()); });
  EXPECT_NE(said.find("garment.obj"), std::string::npos) << said;
  EXPECT_NE(said.find("11, as when"), std::string::npos) << said;
}

}  // namespace
}  // namespace malha
