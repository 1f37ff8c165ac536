// SPDX-License-Identifier: Apache-2.0
// Maps of vertices: what a list, the colours of a file or a picture say of each vertex multiplies stiffness and
// density, and chooses pins.
#include "host/model/vertex_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <sstream>

#include "host/base/file.h"
#include "host/mesh/io/mesh_io.h"
#include "host/model/model.h"
#include "host/render/image.h"
#include "host/run/checkpoint.h"
#include "malha/simulation.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/numbers.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// An irregular sheet in the unit square as OBJ, with a colour at each vertex and its place as texture coordinates.
std::string coloured_obj(const Mesh& sheet, const std::function<Vec3(const Vec3&)>& colour) {
  std::ostringstream text;
  text.precision(9);
  for (const Vec3& x : sheet.points) {
    const Vec3 c = colour(x);
    text << "v " << x[0] << ' ' << x[1] << ' ' << x[2] << ' ' << c[0] << ' ' << c[1] << ' ' << c[2] << "\nvt " << x[0]
         << ' ' << x[2] << '\n';
  }
  for (const Quad& f : sheet.faces) {
    text << 'f';
    for (const int v : f)
      if (v >= 0) text << ' ' << v + 1 << '/' << v + 1;
    text << '\n';
  }
  return text.str();
}

/// A picture whose red grows from left to right, and whose green from below.
std::string ramps(const TemporaryFolder& folder) {
  Image image{64, 64, std::vector<std::uint8_t>(3 * 64 * 64, 0)};
  for (std::size_t j = 0; j < 64; ++j)
    for (std::size_t i = 0; i < 64; ++i) {
      image.pixels[3 * (64 * j + i)] = static_cast<std::uint8_t>(4 * i);
      image.pixels[3 * (64 * j + i) + 1] = static_cast<std::uint8_t>(4 * (63 - j));
    }
  const std::string path = (folder / "ramps.png").string();
  write_png(path, image);
  return path;
}

class VertexMaps : public testing::Test {
 protected:
  /// An irregular sheet in the unit square of x and z.
  Mesh sheet_of(int cells) const {
    Random random(5);
    return read_mesh(folder_.write("bare.obj", irregular_sheet(1, 1, cells, cells, random)));
  }
  Json body(const std::string& mesh) const {
    return {{"name", "sheet"},
            {"shape", {{"mesh", mesh}}},
            {"density", 0.2},
            {"constraints", {{{"type", "distance"}, {"compliance", 1e-3}}}}};
  }
  Json scene(const Json& one) const {
    return {{"name", "maps"},
            {"duration", 1},
            {"gravity", {0, -9.81, 0}},
            {"solver", {{"type", "pbd"}, {"dt", 0.01}, {"substeps", 5}, {"precision", "double"}}},
            {"bodies", {one}}};
  }
  std::string coloured() const {
    return folder_.write("coloured.obj", coloured_obj(sheet_, [](const Vec3& x) { return Vec3{x[0], x[2], 0.5}; }));
  }

  const TemporaryFolder folder_;
  const Mesh sheet_ = sheet_of(9);
};

TEST_F(VertexMaps, MultiplyTheStiffnessOfEachElementByTheMeanOfItsVertices) {
  Json one = body(coloured());
  one["constraints"][0]["map"] = {{"colours", "red"}, {"range", {0.5, 4}}};
  const Model model = build_model(parsed(scene(one)));
  ASSERT_EQ(model.sets.size(), 1u);
  const ConstraintSet& set = model.sets[0];
  for (int c = 0; c < set.count(); ++c) {
    double factor = 0;
    for (const int i : {set.particles[2 * c], set.particles[2 * c + 1]})
      factor += (0.5 + 3.5 * model.render_mesh.points[model.user_index[i]][0]) / 2;
    EXPECT_NEAR(set.alpha(c), 1e-3 / factor, 1e-9) << "colours and places are read to 9 digits";
  }
}

TEST_F(VertexMaps, OfPicturesAreThoseOfColoursWhereThePictureHasThem) {
  const std::string mesh = coloured(), picture = ramps(folder_);
  const Scene read = parsed(scene(body(mesh)));
  const Mesh shape = read_mesh(mesh);
  for (const auto& [channel, axis] : {std::pair{"red", 0}, {"green", 2}}) {
    VertexMap map;
    map.picture = picture, map.channel = channel, map.range = {10, 20};
    const std::vector<double> values = values_at_points(read.bodies[0].shape, shape, map, {"scene", "/map"});
    for (std::size_t v = 0; v < values.size(); ++v) {
      // Pixel i has the value 4 i / 255 at (i + 1 / 2) / 64, and the picture ends with its last pixels.
      const double pixel = std::clamp(64 * shape.points[v][axis] - 0.5, 0.0, 63.0);
      if (shape.points[v][axis] >= 1) continue;  // the picture begins again
      EXPECT_NEAR(values[v], 10 + 10 * 4 * pixel / 255, 1e-5) << channel << " at vertex " << v;
    }
  }
}

// Both borders belong to a picture: as Blender unwraps a plane, the last column lies at 1 and not at the first again.
TEST_F(VertexMaps, OfPicturesReachTheirBorders) {
  const Scene read = parsed(scene(body(coloured())));
  const Mesh shape = read_mesh(coloured());
  for (const bool last : {false, true}) {
    Image image{2, 2, std::vector<std::uint8_t>(12, 0)};
    for (const std::size_t row : {0u, 1u}) image.pixels[3 * (2 * row + (last ? 1 : 0))] = 255;
    VertexMap map;
    map.picture = (folder_ / "halves.png").string(), map.channel = "red", map.range = {0, 1};
    write_png(map.picture, image);
    const std::vector<double> values = values_at_points(read.bodies[0].shape, shape, map, {"scene", "/map"});
    for (std::size_t v = 0; v < values.size(); ++v) {
      const double x = shape.points[v][0], right = std::clamp(2 * x - 0.5, 0.0, 1.0);
      EXPECT_NEAR(values[v], last ? right : 1 - right, 1e-6) << "at " << x;
    }
  }
}

TEST_F(VertexMaps, SayHowParticlesShareAMass) {
  Json one = body(coloured());
  one.erase("density"), one["mass"] = 3;
  const Model plain = build_model(parsed(scene(one)));
  std::vector<double> values;
  double weighed = 0;
  for (std::size_t v = 0; v < sheet_.points.size(); ++v) values.push_back(1 + 0.1 * static_cast<double>(v % 7));
  for (std::size_t i = 0; i < plain.mass.size(); ++i)
    weighed += plain.mass[i] * values[static_cast<std::size_t>(plain.user_index[i])];
  one["density_map"] = {{"values", values}};
  const Model heavy = build_model(parsed(scene(one)));
  for (std::size_t i = 0; i < plain.mass.size(); ++i)
    EXPECT_NEAR(heavy.mass[i], plain.mass[i] * values[static_cast<std::size_t>(plain.user_index[i])] * 3 / weighed,
                1e-14);
  Json loose = body(coloured());
  loose.erase("density"), loose.erase("constraints"), loose["mass"] = 3;
  loose["shape"] = {{"lattice", {{"min", {0, 0, 0}}, {"max", {1, 0, 0}}, {"count", {3, 1, 1}}}}};
  loose["density_map"] = {{"values", {1, 2, 3}}};
  const Model particles = build_model(parsed(scene(loose)));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(particles.mass[i], 0.5 * (1 + particles.user_index[i]));
}

TEST_F(VertexMaps, MultiplyTheDensity) {
  Json one = body(folder_.write("plain.obj", coloured_obj(sheet_, [](const Vec3&) { return Vec3{1, 1, 1}; })));
  const Model plain = build_model(parsed(scene(one)));
  std::vector<double> values;
  for (std::size_t v = 0; v < sheet_.points.size(); ++v) values.push_back(1 + 0.01 * static_cast<double>(v));
  one["density_map"] = {{"values", values}};
  const Model heavy = build_model(parsed(scene(one)));
  for (std::size_t i = 0; i < plain.mass.size(); ++i)
    EXPECT_DOUBLE_EQ(heavy.mass[i], plain.mass[i] * values[static_cast<std::size_t>(plain.user_index[i])]);
}

TEST_F(VertexMaps, ChooseThePinsAboveABound) {
  Json one = body(coloured());
  one["pins"] = {{{"map", {{"colours", "green"}, {"above", 0.7}}}}};
  const Simulation simulation(parsed(scene(one)), {.threads = 1});
  std::vector<int> expected;
  for (std::size_t v = 0; v < sheet_.points.size(); ++v)
    if (sheet_.points[v][2] > 0.7) expected.push_back(static_cast<int>(v));
  EXPECT_EQ(simulation.pins(), expected);
  EXPECT_GT(expected.size(), 5u);
}

TEST_F(VertexMaps, OfOneAreNoMaps) {
  Json one = body(coloured());
  one["pins"] = {{{"particles", {0}}}};
  const auto hash = [&](const Json& of) {
    Simulation simulation(parsed(scene(of)), {.threads = 2});
    for (int k = 0; k < 5; ++k) simulation.step();
    return simulation.state_hash();
  };
  const std::uint64_t plain = hash(one);
  one["density_map"] = {{"values", std::vector<double>(sheet_.points.size(), 1)}};
  one["constraints"][0]["map"] = {{"colours", "blue"}, {"range", {1, 1}}};
  EXPECT_EQ(hash(one), plain);
  one["constraints"][0]["map"]["range"] = {1, 3};
  EXPECT_NE(hash(one), plain);
}

// A power of two as factor divides the compliance without rounding.
TEST_F(VertexMaps, OfFourEverywhereAreAModulusFourTimesAsLarge) {
  Json one = body(coloured());
  one["pins"] = {{{"particles", {0, 1, 2}}}};
  const auto hash = [&](const char* type, double rigidity, double factor, const char* bending) {
    Json of = one;
    of["constraints"] = {{{"type", "distance"}, {"compliance", 1e-4}}, {{"type", type}, {"rigidity", rigidity}}};
    if (factor != 1) of["constraints"][1]["map"] = {{"colours", "red"}, {"range", {factor, factor}}};
    Json whole = scene(of);
    whole["solver"]["bending"] = bending;
    Simulation simulation(parsed(whole), {.threads = 2});
    for (int k = 0; k < 10; ++k) simulation.step();
    return simulation.state_hash();
  };
  for (const char* type : {"distance", "bending", "isometric_bending", "plate"})
    for (const char* bending : {"projected", "filtered"}) {
      EXPECT_EQ(hash(type, 1e-3, 4, bending), hash(type, 4e-3, 1, bending)) << type << ", " << bending;
      EXPECT_NE(hash(type, 1e-3, 4, bending), hash(type, 1e-3, 1, bending)) << type << ", " << bending;
    }
}

// A checkpoint belongs to the contents of a picture, whose path alone the scene has.
TEST_F(VertexMaps, OfOtherPicturesAreOtherScenes) {
  for (const char* method : {"pbd", "desbrun"})
    for (const char* key : {"map", "rest_scale_map"}) {
      Json one = body(coloured());
      one["pins"] = {{{"particles", {0}}}};
      const auto hash = [&](const std::string& channel) {
        one["constraints"][0][key] = {{"picture", ramps(folder_)}, {"channel", "red"}, {"range", {1, 2}}};
        if (channel == "white")
          write_png((folder_ / "ramps.png").string(), Image{4, 4, std::vector<std::uint8_t>(3 * 4 * 4, 200)});
        Json whole = scene(one);
        whole["solver"]["type"] = method;
        return scene_hash(build_model(parsed(whole)));
      };
      EXPECT_EQ(hash("red"), hash("red")) << method << ", " << key;
      EXPECT_NE(hash("red"), hash("white")) << method << ", " << key;
    }
}

TEST_F(VertexMaps, AreRefusedWhereTheyCannotBe) {
  const std::string mesh = coloured();
  const auto said = [&](const std::function<void(Json&)>& change) {
    Json one = body(mesh);
    change(one);
    return refusal([&] { build_model(parsed(scene(one))); });
  };
  const auto map = [](Json value) { return [value](Json& one) { one["constraints"][0]["map"] = value; }; };
  EXPECT_NE(said(map({{"values", {1, 2}}})).find("/bodies/0/constraints/0/map: found 2 values"), std::string::npos);
  EXPECT_NE(said(map({{"colours", "red"}})).find("the factor 0 at vertex"), std::string::npos);
  EXPECT_NE(said(map({{"colours", "pink"}})).find("red, green, blue, alpha"), std::string::npos);
  EXPECT_NE(said(map({{"colours", "red"}, {"channel", "red"}})).find("'channel' without 'picture'"), std::string::npos);
  EXPECT_NE(said(map({{"picture", "nowhere.png"}})).find("nowhere.png"), std::string::npos);
  EXPECT_NE(said(map({{"picture", mesh}})).find("a PNG or JPEG file"), std::string::npos);
  EXPECT_NE(said([](Json& one) {
              one["constraints"][0].erase("compliance"), one["constraints"][0]["map"] = {{"colours", "red"}};
            }).find("does not give way"),
            std::string::npos);
  EXPECT_NE(said([](Json& one) {
              one["shape"] = {{"grid", {{"size", {1, 1}}, {"cells", {2, 2}}}}};
              one["constraints"][0]["map"] = {{"colours", "red"}};
            }).find("a generated shape"),
            std::string::npos);
}

TEST_F(VertexMaps, AreWrittenAsTheyAreRead) {
  Json one = body(coloured());
  one["constraints"][0]["map"] = {{"picture", ramps(folder_)}, {"channel", "green"}, {"range", {0.5, 2}}};
  one["density_map"] = {{"colours", "blue"}, {"range", {1, 3}}};
  one["pins"] = {{{"map", {{"colours", "red"}, {"range", {0, 1}}, {"above", 0.25}}}}};
  const std::string text = to_json(parsed(scene(one)));
  EXPECT_EQ(to_json(parse_scene(text, "again", "")), text);
  EXPECT_EQ(Json::parse(text)["bodies"][0]["constraints"][0]["map"], one["constraints"][0]["map"]);
}

TEST(VertexColours, AreReadFromPlyAsFromObj) {
  const TemporaryFolder folder;
  const std::string text =
      folder.write("a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                   "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar "
                   "blue\nproperty uchar alpha\nelement face 1\nproperty list uchar int "
                   "vertex_indices\nend_header\n0 0 0 255 0 51 255\n1 0 0 0 255 0 0\n0 1 0 0 0 255 "
                   "128\n3 0 1 2\n");
  const FileMesh ply = read_file_mesh(text, {}, Attributes::All);
  ASSERT_EQ(ply.colours.size(), 3u);
  EXPECT_EQ(ply.colours[0], (std::array{1.0f, 0.0f, 0.2f, 1.0f}));
  EXPECT_EQ(ply.colours[2], (std::array{0.0f, 0.0f, 1.0f, 128 / 255.0f}));
  const FileMesh obj =
      read_file_mesh(folder.write("a.obj", "v 0 0 0 1 0 0.2\nv 1 0 0\nv 0 1 0 0 0 1\nf 1 2 3\n"), {}, Attributes::All);
  EXPECT_EQ(obj.colours, (std::vector<std::array<float, 4>>{{1, 0, 0.2f, 1}, {1, 1, 1, 1}, {0, 0, 1, 1}}));
}

}  // namespace
}  // namespace malha
