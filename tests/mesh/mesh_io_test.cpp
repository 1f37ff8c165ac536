// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/io/mesh_io.h"

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <cstdint>
#include <sstream>

#include "host/mesh/generate.h"
#include "tests/mesh/mesh_files.h"

namespace malha {
namespace {

namespace fs = std::filesystem;

using ReadMesh = MeshFiles;

// A house: a cube of quads, whose lid is a roof of four triangles. Closed, with both kinds of faces.
const std::vector<Vec3> house_points{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1},       {0, 1, 0},
                                     {1, 1, 0}, {1, 1, 1}, {0, 1, 1}, {0.5, 1.25, 0.5}};
const std::vector<Quad> house_faces{{0, 1, 2, 3},  {0, 4, 5, 1},  {1, 5, 6, 2},  {2, 6, 7, 3}, {3, 7, 4, 0},
                                    {4, 7, 8, -1}, {7, 6, 8, -1}, {6, 5, 8, -1}, {5, 4, 8, -1}};

const std::string house_obj =
    "# a house\r\n"
    "mtllib house.mtl\r\n"
    "o house\r\n"
    "v 0 0 0\r\nv 1 0 0\r\nv 1 0 1\r\nv 0 0 1\r\nv 0 1 0 1.0\r\nv 1 1 0 0.5 0.5 0.5\r\nv 1 1 1\r\nv 0 1 1\r\n"
    "v +.5 125e-2 0.5 # the ridge\r\n"
    "vn 0 -1 0\r\nvt 0.25 0.75\r\n"
    "g walls\r\ns off\r\nusemtl stone\r\n"
    "f 1 2 3 4\r\nf 1/1 5/1 6/1 2/1\r\nf 2//1 6//1 7//1 3//1\r\nf 3/1/1 7/1/1 8/1/1 4/1/1\r\n\tf  4 8 5 1 \r\n"
    "g roof\r\n"
    "f -5 -2 -1\r\nf -2 -3 -1\r\nf 7 6 9\r\nf 6 5 9";

const std::string house_ply_body =
    "0 0 0\n1 0 0\n1 0 1\n0 0 1\n0 1 0\n1 1 0\n1 1 1\n0 1 1\n0.5 1.25 0.5\n"
    "4 0 1 2 3\n4 0 4 5 1\n4 1 5 6 2\n4 2 6 7 3\n4 3 7 4 0\n3 4 7 8\n3 7 6 8\n3 6 5 8\n3 5 4 8\n";
const std::string house_ply =
    "ply\nformat ascii 1.0\ncomment a house\nelement vertex 9\nproperty float x\nproperty float y\nproperty double z\n"
    "element face 9\nproperty list uchar int vertex_indices\nend_header\n" +
    house_ply_body;

const std::string house_off = "OFF\n# a house\n9 9 0\n\n" + house_ply_body;

void expect_house(const Mesh& mesh) {
  EXPECT_EQ(mesh.points, house_points);
  EXPECT_EQ(mesh.faces, house_faces);
  EXPECT_TRUE(mesh.lines.empty());
}

// The house with z first, a normal's x between, a list and a double to skip, an unknown element before the faces, and
// unsigned short corners after a flag.
std::string binary_house(bool big) {
  std::string bytes =
      std::string("ply\r\nformat binary_") + (big ? "big" : "little") +
      "_endian 1.0\r\nobj_info -\r\nelement vertex 9\r\nproperty float z\r\nproperty short nx\r\nproperty double x\r\n"
      "property list uint8 int16 tags\r\nproperty float32 y\r\nelement camera 1\r\nproperty int64x\r\n";
  bytes = bytes.substr(0, bytes.rfind("property")) +
          "property uint number\r\nelement face 9\r\nproperty uchar flag\r\nproperty list int ushort vertex_index\r\n"
          "end_header\r\n";
  for (const Vec3& point : house_points) {
    append(bytes, static_cast<float>(point[2]), big);
    append(bytes, std::int16_t{-7}, big);
    append(bytes, point[0], big);
    append(bytes, std::uint8_t{2});
    append(bytes, std::int16_t{1}, big);
    append(bytes, std::int16_t{2}, big);
    append(bytes, static_cast<float>(point[1]), big);
  }
  append(bytes, std::uint32_t{42}, big);
  for (const Quad& face : house_faces) {
    append(bytes, std::uint8_t{1});
    append(bytes, std::int32_t{is_triangle(face) ? 3 : 4}, big);
    for (const int corner : face) {
      if (corner >= 0) append(bytes, static_cast<std::uint16_t>(corner), big);
    }
  }
  return bytes;
}

// Corners in the order of first appearance: 0, 2, 1, 3 of the tetrahedron.
void expect_welded_tetrahedron(const Mesh& mesh) {
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{tetrahedron[0], tetrahedron[2], tetrahedron[1], tetrahedron[3]}));
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, -1}, {0, 2, 3, -1}, {2, 1, 3, -1}, {1, 0, 3, -1}}));
}

TEST_F(ReadMesh, ReadsTheSameHouseFromEveryFormatWithQuads) {
  expect_house(read_mesh(file("house.obj", house_obj)));
  expect_house(read_mesh(file("house.ply", house_ply)));
  expect_house(read_mesh(file("little.ply", binary_house(false))));
  expect_house(read_mesh(file("big.ply", binary_house(true))));
  expect_house(read_mesh(file("house.off", house_off)));
}

TEST_F(ReadMesh, TakesTheExtensionInAnyCase) {
  expect_house(read_mesh(file("HOUSE.OBJ", house_obj)));
  expect_house(read_mesh(file("house.Off", house_off)));
}

TEST_F(ReadMesh, TakesLineEndsOfAllSystemsAndAByteOrderMark) {
  for (const std::string& text : {house_ply, house_off}) {
    const std::string name = text == house_ply ? "a.ply" : "a.off";
    for (const std::string end : {"\r\n", "\r"}) {
      std::string changed = "\xEF\xBB\xBF";
      for (const char letter : text) changed += letter == '\n' ? end : std::string(1, letter);
      expect_house(read_mesh(file(name, changed)));
    }
  }
}

TEST_F(ReadMesh, WeldsExactlyEqualCornersOfStl) {
  expect_welded_tetrahedron(read_mesh(file("ascii.stl", ascii_stl())));
  expect_welded_tetrahedron(read_mesh(file("binary.stl", binary_stl("exported"))));
  std::string minus_zero = ascii_stl();
  minus_zero.replace(minus_zero.rfind("vertex 0 0 1"), 12, "vertex -0 0.0 1");
  expect_welded_tetrahedron(read_mesh(file("minus.stl", minus_zero)));
}

// The layout is that which common programs write.
TEST_F(ReadMesh, ReadsAsciiStlInCapitalsInTwoWordsWithoutANameAndWithAnyLineEnds) {
  const auto changed_all = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
    return text;
  };
  std::string capitals = ascii_stl(), two_words = ascii_stl(), some = ascii_stl();
  for (char& letter : capitals) letter = static_cast<char>(std::toupper(letter));
  for (const char* word : {"loop", "facet", "solid"})
    two_words = changed_all(two_words, std::string("end") + word, std::string("end ") + word);
  for (const char* word : {"solid", "facet", "vertex"})
    some = changed_all(some, word, static_cast<char>(std::toupper(word[0])) + std::string(word + 1));
  const std::string no_name = changed_all(ascii_stl(), "solid tetra hedron", "solid");
  const std::string all = changed_all(changed_all(capitals, "END", "END "), " TETRA HEDRON", "");
  for (const std::string& text : {ascii_stl(), capitals, two_words, some, no_name, all}) {
    expect_welded_tetrahedron(read_mesh(file("lf.stl", text)));
    expect_welded_tetrahedron(read_mesh(file("crlf.stl", changed_all(text, "\n", "\r\n"))));
    expect_welded_tetrahedron(read_mesh(file("cr.stl", changed_all(text, "\n", "\r"))));
    expect_welded_tetrahedron(read_mesh(file("mark.stl", "\xEF\xBB\xBF\n  " + text)));
  }
}

TEST_F(ReadMesh, KnowsABinaryStlThatStartsLikeAnAsciiOne) {
  expect_welded_tetrahedron(read_mesh(file("sly.stl", binary_stl("solid block"))));
}

TEST_F(ReadMesh, AgreesWithTinyobjloader) {
  std::ostringstream text;  // every way to name a corner, on more points than could match by accident
  const Mesh box = generate(BoxShape{{1.5, 2.25, 3.125}, {{3, 2, 4}}});
  for (const Vec3& p : box.points) text << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  text << "vn 1 0 0\nvt 0 0\n";
  for (std::size_t i = 0; i < box.faces.size(); ++i) {
    text << 'f';
    for (const int corner : box.faces[i]) {
      const long from_end = corner - static_cast<long>(box.points.size());
      if (i % 3 == 0) text << ' ' << corner + 1;
      if (i % 3 == 1) text << ' ' << from_end << "//1";
      if (i % 3 == 2) text << ' ' << corner + 1 << "/1/1";
    }
    text << '\n';
  }
  const Mesh ours = read_mesh(file("box.obj", text.str()));

  tinyobj::attrib_t theirs;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  std::istringstream stream(text.str());
  ASSERT_TRUE(tinyobj::LoadObj(&theirs, &shapes, &materials, &warning, &error, &stream, nullptr, false)) << error;
  ASSERT_EQ(theirs.vertices.size(), 3 * ours.points.size());
  for (std::size_t i = 0; i < theirs.vertices.size(); ++i) {
    EXPECT_EQ(theirs.vertices[i],
              static_cast<float>(ours.points[i / 3][i % 3]));  // few digits: no rounding to differ in
  }
  ASSERT_EQ(shapes.size(), 1u);
  ASSERT_EQ(shapes[0].mesh.indices.size(), 4 * ours.faces.size());
  for (std::size_t i = 0; i < shapes[0].mesh.indices.size(); ++i) {
    EXPECT_EQ(shapes[0].mesh.indices[i].vertex_index, ours.faces[i / 4][i % 4]);
  }
}

TEST_F(ReadMesh, MakesFansOfPolygons) {
  const std::vector<Quad> fan{{0, 1, 2, -1}, {0, 2, 3, -1}, {0, 3, 4, -1}};
  const std::string points = "0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n";
  EXPECT_EQ(read_mesh(file("a.off", "OFF 5 1 0\n" + points + "5 0 1 2 3 4\n")).faces, fan);
  EXPECT_EQ(read_mesh(file("a.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n")).faces, fan);
}

TEST_F(ReadMesh, ReadsPolylinesOfObj) {
  const Mesh mesh = read_mesh(file("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3\nl -1 1\n"));
  EXPECT_EQ(mesh.lines, (std::vector<Edge>{{0, 1}, {1, 2}, {2, 0}}));
  EXPECT_TRUE(mesh.faces.empty());
}

TEST_F(ReadMesh, LetsAnObjFacePointAhead) {
  EXPECT_EQ(read_mesh(file("a.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 2 1 0\n")).faces, (std::vector<Quad>{{0, 1, 2, -1}}));
}

TEST_F(ReadMesh, SkipsColoursAndNormalsOfOff) {
  const Mesh mesh = read_mesh(file("a.off",
                                   "COFF 3 1\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n"
                                   "3 0 1 2 0.5 0.5 0.5 # grey\n"));
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, -1}}));
  EXPECT_EQ(read_mesh(file("b.off", "NOFF\n3 0 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n")).points, mesh.points);
}

TEST_F(ReadMesh, KeepsEveryDigit) {
  const double value = 0.71234567890123446;  // needs all 17
  EXPECT_EQ(read_mesh(file("a.obj", "v 0.71234567890123446 0 0\n")).points[0][0], value);
  EXPECT_EQ(read_mesh(file("a.off", "OFF 1 0 0\n0.71234567890123446 0 0\n")).points[0][0], value);
}

TEST_F(ReadMesh, RefusesWhatIsNoMeshFile) {
  const std::string missing = (folder_ / "none.obj").string();
  EXPECT_EQ(refusal([&] { read_mesh(missing); }),
            missing + ": cannot read: No such file or directory; allowed: a readable mesh file");
  fs::create_directory(folder_ / "folder.ply");
  EXPECT_EQ(refusal([&] { read_mesh((folder_ / "folder.ply").string()); }),
            (folder_ / "folder.ply").string() + ": cannot read: Is a directory; allowed: a readable mesh file");
  const std::string unknown = file("a.fbx", "");
  EXPECT_EQ(refusal([&] { read_mesh(unknown); }),
            unknown +
                ": found the extension \".fbx\"; allowed: .obj, .ply, .off, .stl, "
                ".glb or .gltf, or with tetrahedra .mesh, .msh, .node or .ele");
}

}  // namespace
}  // namespace malha
