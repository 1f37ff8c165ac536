// SPDX-License-Identifier: Apache-2.0
// Every kind of bad input through the command: exit status 2, one line that names the file, the position, what was
// found and what is allowed, and nothing written; or, where a run can go on correctly, a counted skip.
#include <algorithm>

#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A sheet over a ball; each case makes one thing in it invalid.
Json sound_scene() {
  return Json::parse(R"({
    "name": "sound",
    "solver": {"type": "pbd", "dt": 0.01},
    "gravity": [0, -9.81, 0],
    "bodies": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [2, 2]}}, "mass": 1,
                "transform": {"translate": [0, 1, 0]},
                "constraints": [{"type": "distance", "elements": ["edges"], "stiffness": 1}]}],
    "environment": [{"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 1}}}],
    "duration": 0.02,
    "outputs": {"frames": {"every": 1, "formats": ["vtp"]}}
  })");
}

struct BadCase {
  std::string name;
  std::string pointer, value;  // the JSON at this pointer of the scene is replaced by this value
  std::string mesh, bytes;     // a mesh file of this name beside the scene
  std::string found, allowed;  // the start of the line, and the start of its list of what is allowed
};
void PrintTo(const BadCase& bad, std::ostream* out) { *out << bad.name; }

/// A folder with a scene and the results of an earlier run, which a refused run must not change.
class RefusalFolder {
 public:
  explicit RefusalFolder(const std::string& scene) {
    write("scene.json", scene);
    std::filesystem::create_directories(folder_ / "out/frames");
    std::filesystem::create_directory(folder_ / "folder.obj");
    for (const char* name : {"out/report.json", "out/checkpoint.malha", "out/frames/frame_000000.vtp"})
      write(name, "of an earlier run");
  }
  void write(const std::string& name, const std::string& bytes) const { folder_.write(name, bytes); }

  void expect_refusal(const std::string& found, const std::string& allowed) const {
    const auto before = files_in(folder_ / ".");
    const Ended run = malha_command({"run", "scene.json", "--out", "out"}, folder_ / ".");
    EXPECT_EQ(run.status, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.err.find(found), 0u) << run.err;
    EXPECT_NE(run.err.find("; allowed: " + allowed, found.size()), std::string::npos) << run.err;
    EXPECT_TRUE(files_in(folder_ / ".") == before);

    const Ended check = malha_command({"check", "scene.json"}, folder_ / ".");
    EXPECT_EQ(check.status, 2);
    EXPECT_EQ(check.err, run.err);
  }

 private:
  TemporaryFolder folder_;
};

class BadInput : public testing::TestWithParam<BadCase> {};

TEST_P(BadInput, IsRefusedInOneLineAndNothingIsWritten) {
  const BadCase& bad = GetParam();
  Json scene = sound_scene();
  scene[Json::json_pointer(bad.pointer)] = Json::parse(bad.value);
  const RefusalFolder folder(scene.dump());
  if (!bad.mesh.empty()) folder.write(bad.mesh, bad.bytes);
  folder.expect_refusal(bad.found, bad.allowed);
}

std::string name_of(const testing::TestParamInfo<BadCase>& one) { return one.param.name; }

const std::string obj_corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const std::string open_cube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n";  // the face 4 1 5 8 is missing
const std::string cube_with_a_turned_face = open_cube + "f 8 5 1 4\n";
const std::string cut_ply =
    "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "end_header\n" +
    std::string(35, '\0');  // of 36 bytes

/// Replaces the mesh of the body or of the ball by this file.
BadCase in_mesh(const std::string& name, const std::string& file, const std::string& bytes, const std::string& found,
                const std::string& allowed) {
  return {name, "/bodies/0/shape", R"({"mesh": ")" + file + "\"}", file, bytes, file + ": " + found, allowed};
}
BadCase in_solid(const std::string& name, const std::string& bytes, const std::string& found,
                 const std::string& allowed) {
  return {name, "/environment/0/shape", R"({"mesh": "a.obj"})", "a.obj", bytes, "a.obj: " + found, allowed};
}
BadCase under_pressure(const std::string& name, const std::string& bytes, const std::string& found,
                       const std::string& allowed) {
  return {name,    "/bodies/0", R"({"name": "b", "mass": 1, "shape": {"mesh": "a.obj"},
          "constraints": [{"type": "pressure"}]})",
          "a.obj", bytes,       "a.obj: " + found,
          allowed};
}
BadCase in_scene(const std::string& pointer_and_found, const std::string& name, const std::string& pointer,
                 const std::string& value, const std::string& allowed) {
  return {name, pointer, value, "", "", "scene.json: " + pointer_and_found, allowed};
}

INSTANTIATE_TEST_SUITE_P(
    Mesh, BadInput,
    testing::Values(
        BadCase{"Missing", "/bodies/0/shape", R"({"mesh": "none.obj"})", "", "",
                "none.obj: cannot read: No such file or directory", "a readable mesh file"},
        BadCase{"Unreadable", "/bodies/0/shape", R"({"mesh": "folder.obj"})", "", "",
                "folder.obj: cannot read: Is a directory", "a readable mesh file"},
        in_mesh("TruncatedPly", "a.ply", cut_ply, "line 3, column 16: found 3 items of element \"vertex\"",
                "at most 2, as many as the rest of the file can hold"),
        in_mesh("IndexOutOfRange", "a.obj", obj_corners + "f 1 2 4\n", "line 4, column 7: found vertex 4", "1 to 3"),
        in_mesh("NotANumber", "a.off", "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
                "line 4, column 3: found \"nan\"", "y, a finite number"),
        in_mesh("Infinite", "a.obj", "v 0 0 inf\n", "line 1, column 7: found \"inf\"", "z, a finite number"),
        in_mesh("RepeatedTriangle", "a.obj", obj_corners + "f 1 2 3\nf 2 3 1\n",
                "face 1 (0-based): found the vertices 1, 2, 0 of face 0 again", "every face once"),
        in_mesh("OnlyVertices", "a.obj", obj_corners,
                "vertex 0 (0-based): found a vertex of no face, line or tetrahedron", "vertices of faces"),
        in_mesh("DuplicatedVertex", "a.obj", obj_corners + "v 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 5\n",
                "vertex 3 (0-based): found the position of vertex 2 again", "one vertex for each position"),
        under_pressure("OpenUnderPressure", open_cube, "edge 0-3 (vertices, 0-based): found an open edge",
                       "pressure needs a closed mesh (body 'b')"),
        under_pressure("TurnedFaceUnderPressure", cube_with_a_turned_face,
                       "edge 0-3 (vertices, 0-based): found an edge whose two faces have opposite orientations",
                       "pressure needs a closed mesh (body 'b')"),
        in_solid("OpenSolid", open_cube, "edge 0-3 (vertices, 0-based): found an open edge",
                 "a solid needs a closed mesh (object 'ball'; for a sheet: \"sides\": \"two_sided\")"),
        in_solid("TurnedFaceInASolid", cube_with_a_turned_face,
                 "edge 0-3 (vertices, 0-based): found an edge whose two faces have opposite orientations",
                 "a solid needs a closed mesh (object 'ball'; for a sheet: \"sides\": \"two_sided\")")),
    name_of);

const std::string spring = "/bodies/0/constraints/0";
INSTANTIATE_TEST_SUITE_P(
    Scene, BadInput,
    testing::Values(
        in_scene("/bodies/0/mass: found 0", "ZeroMass", "/bodies/0/mass", "0", "a number > 0 (kg)"),
        in_scene("/bodies/0/mass: found -1", "NegativeMass", "/bodies/0/mass", "-1", "a number > 0 (kg)"),
        in_scene(spring + "/compliance: found -1", "NegativeCompliance", spring,
                 R"({"type": "distance", "compliance": -1})", "a number >= 0"),
        in_scene(spring + "/stiffness: found 1.5", "StiffnessAboveOne", spring + "/stiffness", "1.5",
                 "a number in [0, 1]"),
        in_scene(spring + "/stiffness: found -0.5", "StiffnessBelowZero", spring + "/stiffness", "-0.5",
                 "a number in [0, 1]"),
        in_scene("/solver/dt: found 0", "ZeroDt", "/solver/dt", "0", "a number > 0 (s)"),
        in_scene("/bodies/0/color: found unknown key 'color'", "UnknownKey", "/bodies/0/color", "1", "name, shape"),
        in_scene(
            spring + "/type: found unknown constraint \"distence\" (did you mean 'distance'?)", "MisspeltConstraint",
            spring + "/type", "\"distence\"",
            "distance, distance_limit, membrane, bending, isometric_bending, plate, volume, neo_hookean, pressure"),
        in_scene("/bodies: found no body", "NoBodies", "/bodies", "[]", "at least one"),
        in_scene("/bodies/0/pins/0: found no particle there", "PinThatHoldsNothing", "/bodies/0/pins",
                 R"([{"box": {"min": [8, 8, 8], "max": [9, 9, 9]}}])", "a pin that holds a particle")),
    name_of);

struct BadText {
  std::string name, text, found, allowed;
};
void PrintTo(const BadText& bad, std::ostream* out) { *out << bad.name; }

class BadSceneText : public testing::TestWithParam<BadText> {};

TEST_P(BadSceneText, IsRefusedByLineAndColumn) {
  RefusalFolder(GetParam().text).expect_refusal("scene.json: " + GetParam().found, GetParam().allowed);
}

INSTANTIATE_TEST_SUITE_P(
    Json, BadSceneText,
    testing::Values(BadText{"Empty", "", "line 1, column 1: found", ""},
                    BadText{"CutShort", "{\"name\": \"a\",\n", "line 2, column 1: found unexpected end of input", ""},
                    BadText{"ASecondKey", "{\"name\": \"a\",\n \"name\": \"b\"}",
                            "line 2, column 2: found the key 'name' a second time in one object", "each key once"},
                    BadText{"NoFiniteNumber", "{\"duration\": 1e999}", "line 1, column 18: found number overflow",
                            "JSON with finite numbers"}),
    [](const auto& one) { return one.param.name; });

TEST(BadSceneFile, IsRefusedWhereItIsMissingOrUnreadable) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder.json");
  for (const auto& [scene, reason] :
       {std::pair{"none.json", "No such file or directory"}, {"folder.json", "Is a directory"}})
    for (const char* command : {"run", "plan", "check"}) {
      const Ended ended = malha_command({command, scene}, folder / ".");
      EXPECT_EQ(ended.status, 2);
      EXPECT_EQ(ended.err,
                std::string(scene) + ": cannot read: " + reason + "; allowed: a readable scene file (JSON)\n");
    }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(TriangleWithoutArea, IsLeftOutAndCounted) {
  const TemporaryFolder folder;
  folder.write("a.obj", obj_corners + "v 2 0 0\nf 1 2 3\nf 1 2 4\nf 2 4 3\n");  // 1, 2 and 4 lie on a line
  Json scene = sound_scene();
  scene["bodies"][0]["shape"] = {{"mesh", "a.obj"}};
  folder.write("scene.json", scene.dump());
  const Ended run = malha_command({"run", "scene.json", "--threads", "1"}, folder / ".");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("left out    1 face without area\n"), std::string::npos) << run.out;
  EXPECT_EQ(Json::parse(bytes_of(folder / "out/scene/report.json"))["zero_area_faces_dropped"], 1);
  EXPECT_EQ(malha_command({"check", "scene.json"}, folder / ".").out,
            "scene.json: ok: 4 particles in 1 body; left out: 1 face without area\n");
}

}  // namespace
}  // namespace malha
