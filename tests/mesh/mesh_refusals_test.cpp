// SPDX-License-Identifier: Apache-2.0
// Every bad mesh file is refused with its name, the line and column or byte, what was found and what is allowed.
#include <cmath>
#include <cstdint>

#include "host/mesh/io/mesh_io.h"
#include "tests/mesh/mesh_files.h"

namespace malha {
namespace {

struct BadMesh {
  std::string name, text, message;  // the message after "FILE: "
};

class RefusesMesh : public MeshFiles, public testing::WithParamInterface<BadMesh> {};

TEST_P(RefusesMesh, NamingTheFileAndThePlace) {
  const std::string path = file(GetParam().name, GetParam().text);
  EXPECT_EQ(refusal([&] { read_mesh(path); }), path + ": " + GetParam().message);
}

const std::string a_triangle_obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

INSTANTIATE_TEST_SUITE_P(
    Obj, RefusesMesh,
    testing::Values(
        BadMesh{"a.obj", "", "found a mesh without vertices; allowed: one vertex or more"},
        BadMesh{"a.obj", "v 0 0 nan\n",
                "line 1, column 7: found \"nan\"; allowed: z, a finite number in the range of double"},
        BadMesh{"a.obj", "\nv 0 -inf 0\n",
                "line 2, column 5: found \"-inf\"; allowed: y, a finite number in the range of double"},
        BadMesh{"a.obj", "v 0 1e999 0\n",
                "line 1, column 5: found \"1e999\"; allowed: y, a finite number in the range of double"},
        BadMesh{"a.obj", "v 0,5 0 0\n",
                "line 1, column 3: found \"0,5\"; allowed: x, a finite number in the range of double"},
        BadMesh{"a.obj", "v 0 1\n", "line 1, column 6: found the end of the line; allowed: z"},
        BadMesh{"a.obj", a_triangle_obj + "f 1 2 3\nf 1 2 4\nf 3 2 1\n",
                "line 5, column 7: found vertex 4; allowed: 1 to 3 or -3 to -1"},
        BadMesh{"a.obj", a_triangle_obj + "f 1 2 0\n", "line 4, column 7: found vertex 0; allowed: 1 to 3 or -3 to -1"},
        BadMesh{"a.obj", a_triangle_obj + "f 1 -4 2\n",
                "line 4, column 5: found vertex -4; allowed: 1 to 3 or -3 to -1"},
        BadMesh{"a.obj", a_triangle_obj + "f 1 99999999999 2\n",
                "line 4, column 5: found vertex 99999999999; allowed: 1 to 3 or -3 to -1"},
        BadMesh{"a.obj", a_triangle_obj + "l 1 7\n", "line 4, column 5: found vertex 7; allowed: 1 to 3 or -3 to -1"},
        BadMesh{"a.obj", a_triangle_obj + "f 1 2\n",
                "line 4, column 6: found the end of the line; allowed: a face of three or more corners"},
        BadMesh{"a.obj", a_triangle_obj + "l 1\n",
                "line 4, column 4: found the end of the line; allowed: a line of two or more corners"},
        BadMesh{"a.obj", a_triangle_obj + "f 1 2 x/1\n",
                "line 4, column 7: found \"x/1\"; allowed: a corner such as 7, 7/1, 7//3 or -1"},
        BadMesh{"a.obj", "f 1 2 3\n",
                "line 1, column 7: found vertex 3; allowed: no index, because the file has no vertices"},
        BadMesh{"a.obj", "vertex 0 0 0\n",
                "line 1, column 1: found \"vertex\"; allowed: v, f, l, or an ignored keyword (vt, vn, g, o, s, "
                "usemtl ...)"}));

INSTANTIATE_TEST_SUITE_P(
    Off, RefusesMesh,
    testing::Values(
        BadMesh{"a.off", "", "line 0: found the end of the file; allowed: a header: OFF, COFF or NOFF"},
        BadMesh{"a.off", "3 1 0\n", "line 1, column 1: found \"3\"; allowed: a header: OFF, COFF or NOFF"},
        BadMesh{"a.off", "OFF\n0 0 0\n", "found a mesh without vertices; allowed: one vertex or more"},
        BadMesh{"a.off", "OFF\n",
                "line 1: found the end of the file; allowed: the numbers of vertices, faces and edges"},
        BadMesh{"a.off", "OFF\n1000000000000 0 0\n0 0 0\n",
                "line 2, column 1: found 1000000000000 as the number of vertices; allowed: 0 to 2, as many as the rest "
                "of the file can hold"},
        BadMesh{"a.off", "OFF\n1 1000000000000 0\n0 0 0\n",
                "line 2, column 3: found 1000000000000 as the number of faces; allowed: 0 to 1, as many as the rest of "
                "the file can hold"},
        BadMesh{"a.off", "OFF\n-1 0 0\n",
                "line 2, column 1: found -1 as the number of vertices; allowed: 0 to 1, as many as the rest of the "
                "file can hold"},
        BadMesh{"a.off", "OFF 2.5 0 0\n",
                "line 1, column 5: found \"2.5\"; allowed: the number of vertices, an integer"},
        BadMesh{"a.off", "OFF 2 0 0\n0.125 0 0\n# no more\n",
                "line 3: found the end of the file; allowed: vertex 1 (0-based) of 2"},
        BadMesh{"a.off", "OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0.5 0.5\n",
                "line 5: found the end of the file; allowed: face 1 (0-based) of 2"},
        BadMesh{"a.off", "OFF 1 0 0\n0 nan 0\n",
                "line 2, column 3: found \"nan\"; allowed: y, a finite number in the range of double"},
        BadMesh{"a.off", "OFF 1 0 0\n0 0 0 1\n",
                "line 2, column 7: found \"1\"; allowed: x, y, z and then the end of the line"},
        BadMesh{"a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
                "line 5, column 7: found vertex 3; allowed: 0 to 2"},
        BadMesh{"a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
                "line 5, column 7: found vertex -1; allowed: 0 to 2"},
        BadMesh{"a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1 2\n",
                "line 5, column 1: found a face of 2 corners; allowed: 3 or more"},
        BadMesh{"a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n    ",
                "line 5, column 6: found the end of the line; allowed: a corner"},
        BadMesh{"a.off", "OFF 1 0 0\n0 0 0\n0 0 0\n",
                "line 3, column 1: found a line after the last face; allowed: as many lines as the header announces"}));

std::string ply(const std::string& header, const std::string& body) {
  return "ply\nformat ascii 1.0\n" + header + "end_header\n" + body;
}
const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
const std::string triangle_header =
    "element vertex 3\n" + xyz + "element face 1\nproperty list uchar int vertex_indices\n";

INSTANTIATE_TEST_SUITE_P(
    AsciiPly, RefusesMesh,
    testing::Values(
        BadMesh{"a.ply", "", "line 0, column 1: found no PLY header; allowed: \"ply\" on the first line"},
        BadMesh{"a.ply", "ply\nformat ascii 1.0\n", "line 2: found the end of the file; allowed: end_header"},
        BadMesh{"a.ply", "ply\nformat text 1.0\n",
                "line 2, column 8: found \"text\"; allowed: ascii, binary_little_endian or binary_big_endian"},
        BadMesh{"a.ply", "ply\nend_header\n",
                "line 2, column 1: found a header without format; allowed: format ascii 1.0, or binary"},
        BadMesh{"a.ply", ply("", ""), "line 3, column 1: found a header without element \"vertex\"; allowed: one"},
        BadMesh{"a.ply", ply("element vertex 1\n" + xyz + "element vertex 1\n" + xyz, ""),
                "line 11, column 1: found a header with more than one element \"vertex\"; allowed: one"},
        BadMesh{"a.ply", ply("element vertex 0\n" + xyz, ""),
                "found a mesh without vertices; allowed: one vertex or more"},
        BadMesh{"a.ply", ply("element vertex 1\nproperty float x\nproperty float y\n", "0 0\n"),
                "line 3, column 16: found an element \"vertex\" without x, y and z; allowed: properties x, y and z"},
        BadMesh{
            "a.ply",
            ply("element vertex 1\n" + xyz + "element face 0\nproperty list uchar float vertex_indices\n", "0 0 0\n"),
            "line 7, column 14: found an element \"face\" without corners; allowed: a list vertex_indices (or "
            "vertex_index) of an integer type"},
        BadMesh{
            "a.ply", ply("element vertex 1\nproperty real x\n", ""),
            "line 4, column 10: found \"real\"; allowed: char, uchar, short, ushort, int, uint, float, double or int8 "
            "to "
            "float64"},
        BadMesh{"a.ply", ply("element vertex 1\nproperty list float int x\n", ""),
                "line 4, column 15: found a list with a count of a floating-point type; allowed: a count of an integer "
                "type"},
        BadMesh{
            "a.ply", ply("elements vertex 1\n", ""),
            "line 3, column 1: found \"elements\"; allowed: format, comment, element, property (after an element) or "
            "end_header"},
        BadMesh{"a.ply", ply("element vertex -1\n" + xyz, ""),
                "line 3, column 16: found -1; allowed: a count of 0 or more"},
        BadMesh{"a.ply", ply("element vertex 1000000000000\n" + xyz, "0 0 0\n"),
                "line 3, column 16: found 1000000000000 items of element \"vertex\"; allowed: at most 1, as many as "
                "the rest of the file can hold"},
        BadMesh{"a.ply", ply("element vertex 2\n" + xyz, "0 0 0.12345678\n"),
                "line 8: found the end of the file; allowed: vertex 1 (0-based) of 2"},
        BadMesh{"a.ply", ply(triangle_header, "0 0 0\n1 0 0\n0 1 0\n3 0 1\n"),
                "line 13, column 6: found the end of the line; allowed: a count or an index"},
        BadMesh{"a.ply", ply(triangle_header, "0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n"),
                "line 12, column 5: found \"nan\"; allowed: a coordinate, a finite number in the range of double"},
        BadMesh{"a.ply", ply(triangle_header, "0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n"),
                "line 11, column 5: found \"zero\"; allowed: a coordinate, a finite number in the range of double"},
        BadMesh{
            "a.ply", ply(triangle_header, "0 0 0\n1 0 0\n0 1 0 5\n3 0 1 2\n"),
            "line 12, column 7: found \"5\"; allowed: as many values as the header says and then the end of the line"},
        BadMesh{"a.ply", ply(triangle_header, "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
                "line 13, column 7: found vertex 3; allowed: 0 to 2"},
        BadMesh{"a.ply", ply(triangle_header, "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n"),
                "line 13, column 5: found vertex -1; allowed: 0 to 2"},
        BadMesh{"a.ply", ply(triangle_header, "0 0 0\n1 0 0\n0 1 0\n2 0 1\n"),
                "line 13, column 1: found a face of 2 corners; allowed: 3 or more"},
        BadMesh{"a.ply", ply(triangle_header, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"),
                "line 14, column 1: found data after the last item; allowed: as many items as the header says"}));

// The bytes of three points and one face, and where they begin.
struct BinaryTriangle {
  std::string header = "ply\nformat binary_little_endian 1.0\n" + triangle_header + "end_header\n";
  std::string points, face;

  explicit BinaryTriangle(float last = 0, std::uint8_t corners = 3, std::int32_t corner = 2) {
    for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, last}) append(points, value);
    append(face, corners);
    for (const std::int32_t index : {0, 1, corner}) append(face, index);
  }
  std::string bytes() const { return header + points + face; }
  std::string byte(std::size_t after_header) const {
    return "byte " + std::to_string(header.size() + after_header) + ": ";
  }
};

using RefusesBinaryPly = MeshFiles;

TEST_F(RefusesBinaryPly, NamingTheByte) {
  const auto message = [&](const std::string& bytes) {
    const std::string path = file("b.ply", bytes), said = refusal([&] { read_mesh(path); });
    return said.starts_with(path + ": ") ? said.substr(path.size() + 2) : "no file named: " + said;
  };
  const BinaryTriangle good;
  EXPECT_EQ(read_mesh(file("b.ply", good.bytes())).faces, (std::vector<Quad>{{0, 1, 2, -1}}));
  const std::string most = ", as many as the rest of the file can hold";
  EXPECT_EQ(message(good.header + good.points.substr(0, 35)),
            "line 3, column 16: found 3 items of element \"vertex\"; allowed: at most 2" + most);
  EXPECT_EQ(message(good.header + good.points),
            "line 7, column 14: found 1 items of element \"face\"; allowed: at most 0" + most);
  EXPECT_EQ(message(good.bytes().substr(0, good.bytes().size() - 1)),
            good.byte(36 + 1 + 8) + "found the end of the file after 3 bytes; allowed: face 0 (0-based) of 1");
  EXPECT_EQ(message(good.bytes() + "x"),
            good.byte(36 + 13) + "found data after the last item; allowed: as many items as the header says");
  EXPECT_EQ(message(BinaryTriangle(NAN).bytes()),
            good.byte(32) + "found a NaN or infinite coordinate in vertex 2 (0-based) of 3; allowed: finite numbers");
  EXPECT_EQ(message(BinaryTriangle(INFINITY).bytes()),
            good.byte(32) + "found a NaN or infinite coordinate in vertex 2 (0-based) of 3; allowed: finite numbers");
  EXPECT_EQ(message(BinaryTriangle(0, 3, 3).bytes()), good.byte(36 + 1 + 8) + "found vertex 3; allowed: 0 to 2");
  EXPECT_EQ(message(BinaryTriangle(0, 3, -1).bytes()), good.byte(36 + 1 + 8) + "found vertex -1; allowed: 0 to 2");
  EXPECT_EQ(message(BinaryTriangle(0, 2).bytes()), good.byte(36) + "found a face of 2 corners; allowed: 3 or more");
}

TEST_F(RefusesBinaryPly, ThatAnnouncesMoreThanItsSize) {
  std::string bytes = BinaryTriangle().bytes();
  bytes.replace(bytes.find("vertex 3"), 8, "vertex 1000000000000");
  const std::string path = file("b.ply", bytes);
  EXPECT_EQ(refusal([&] { read_mesh(path); }),
            path +
                ": line 3, column 16: found 1000000000000 items of element \"vertex\"; allowed: at most 4, as many as "
                "the rest of the file can hold");
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

INSTANTIATE_TEST_SUITE_P(
    Stl, RefusesMesh,
    testing::Values(
        BadMesh{"a.stl", "",
                "byte 0: found the end of the file after 0 bytes; allowed: a binary header of 84 bytes, or \"solid\" "
                "(ascii)"},
        BadMesh{"a.stl", "solid empty\nendsolid empty\n", "found a mesh without vertices; allowed: one vertex or more"},
        BadMesh{"a.stl", ascii_stl().substr(0, ascii_stl().find("endsolid")),
                "line 29: found the end of the file; allowed: facet or endsolid"},
        BadMesh{"a.stl", ascii_stl().substr(0, ascii_stl().find("   vertex")),
                "line 3: found the end of the file; allowed: vertex"},
        BadMesh{"a.stl", changed(ascii_stl(), "vertex 0 1 0", "vertex 0 inf 0"),
                "line 5, column 13: found \"inf\"; allowed: y, a finite number in the range of double"},
        BadMesh{"a.stl", changed(ascii_stl(), "vertex 0 1 0", "vertex 0 1"),
                "line 5, column 14: found the end of the line; allowed: z"},
        BadMesh{"a.stl", changed(ascii_stl(), "vertex 0 1 0", "vertex 0 1 0 0"),
                "line 5, column 17: found \"0\"; allowed: vertex x y z and then the end of the line"},
        BadMesh{"a.stl", changed(ascii_stl(), "  endloop", "  vertex 1 1 1"),
                "line 7, column 3: found \"vertex\"; allowed: endloop"},
        BadMesh{"a.stl", changed(ascii_stl(), " facet", " face"),
                "line 2, column 2: found \"face\"; allowed: facet or endsolid"},
        BadMesh{"a.stl", binary_stl("").substr(0, 283),
                "byte 80: found 4 triangles in a file of 283 bytes; allowed: 284 bytes for this number"},
        BadMesh{"a.stl", binary_stl("solid block").substr(0, 283),
                "byte 80: found 4 triangles in a file of 283 bytes; allowed: 284 bytes for this number"},
        BadMesh{"a.stl", binary_stl("") + "x",
                "byte 80: found 4 triangles in a file of 285 bytes; allowed: 284 bytes for this number"},
        BadMesh{
            "a.stl", binary_stl("").replace(80, 4, "\xff\xff\xff\xff"),
            "byte 80: found 4294967295 triangles in a file of 284 bytes; allowed: 214748364834 bytes for this number"},
        BadMesh{"a.stl", binary_stl("").replace(84 + 50 + 12 + 3, 1, "\x7f").replace(84 + 50 + 12 + 2, 1, "\xc0"),
                "byte 146 (triangle 1, 0-based): found a NaN or infinite coordinate; allowed: finite numbers"}));

}  // namespace
}  // namespace malha
