// SPDX-License-Identifier: Apache-2.0
// Vertices of mesh files that nothing uses, or that are welded, become no particles of their own, but keep their
// numbers.
#include "tests/mesh/file_vertices.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <stdexcept>

#include "host/mesh/check_mesh.h"
#include "host/mesh/generate.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/weld.h"
#include "host/model/model.h"
#include "host/report/expect.h"
#include "host/run/redraw.h"
#include "malha/simulation.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// The swinging sheet with this mesh in place of its grid, rotated and translated, in double.
Json swinging_file(const std::string& path, const std::vector<int>& pins) {
  Json scene = swinging_sheet(false, "double");
  Json& body = scene["bodies"][0];
  body["shape"] = {{"mesh", path}};
  body["transform"]["rotate"] = {{"axis", {0, 1, 0.5}}, {"degrees", 30}};
  body["pins"] = {{{"particles", pins}}};
  body["constraints"] = {{{"type", "distance"}, {"compliance", 1e-4}}};
  return scene;
}

/// The initial positions of a file's vertices.
std::vector<Vec3> placed(const std::vector<Vec3>& points, const Json& scene) {
  Mesh mesh{points, {}, {}, {}};
  apply(parsed(scene).bodies[0].transform, mesh);
  return mesh.points;
}

std::vector<int> numbers_in(const Interspersed& all, const std::vector<int>& vertices) {
  std::vector<int> numbers;
  for (const int vertex : vertices) numbers.push_back(all.number[vertex]);
  return numbers;
}

/// The velocities of a frame in binary PLY of doubles.
std::vector<Vec3> ply_velocities(const std::filesystem::path& path, std::size_t count) {
  const std::string bytes = bytes_of(path), end = "end_header\n";
  EXPECT_TRUE(has(bytes, "element vertex " + std::to_string(count) + "\n"));
  std::vector<Vec3> velocities(count);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(&velocities[i], bytes.data() + bytes.find(end) + end.size() + i * 48 + 24, 24);
  return velocities;
}

struct FileOf {
  const char* name;
  const Mesh* whole;
  const Interspersed* all;
  std::function<std::string(const TemporaryFolder&, const std::string&, const Mesh&)> write;
};

TEST(FileVertices, OfAnyFormatThatNothingUsesAreCountedByPinsAndFramesAndStayWhereTheyStart) {
  const Mesh sheet = mixed_sheet(3, true, 2), block = generate(TetBoxShape{{1, 1, 1}, {2, 2, 2}});
  const Interspersed thin = interspersed(sheet, 4), full = interspersed(block, 5);
  const auto as = [](const std::string& extension, const std::function<std::string(const Mesh&)>& text) {
    return [=](const TemporaryFolder& folder, const std::string& name, const Mesh& mesh) {
      return folder.write(name + extension, text(mesh));
    };
  };
  const FileOf formats[] = {
      {"OBJ", &sheet, &thin, as(".obj", [](const Mesh& mesh) { return obj_of(mesh); })},
      {"PLY", &sheet, &thin, as(".ply", ply_text_of)},
      {"OFF", &sheet, &thin, as(".off", off_text_of)},
      {"Gmsh", &block, &full, as(".msh", gmsh_text_of)},
      {"Medit", &block, &full, as(".mesh", medit_text_of)},
      {"TetGen", &block, &full, write_tetgen},
  };
  for (const auto& [name, whole, all, write] : formats) {
    SCOPED_TRACE(name);
    const TemporaryFolder folder;
    const std::vector<int> pins{0, 2, 5};
    Json clean = swinging_file(write(folder, "clean", *whole), pins),
         mixed = swinging_file(write(folder, "mixed", all->mesh), numbers_in(*all, pins));
    for (Json* scene : {&clean, &mixed}) (*scene)["outputs"]["frames"] = {{"every", 5}, {"formats", {"obj", "ply"}}};
    run_quietly(clean, {.out = folder / "c", .steps = 10});
    run_quietly(mixed, {.out = folder / "m", .steps = 10});
    const std::vector<Vec3> start = placed(all->mesh.points, mixed);
    for (int frame = 0; frame <= 2; ++frame) {
      const std::string file = "frames/frame_00000" + std::to_string(frame);
      const DrawnObj expected = drawn_file(folder / ("c/" + file + ".obj")),
                     found = drawn_file(folder / ("m/" + file + ".obj"));
      ASSERT_EQ(found.places.size(), start.size());
      const std::vector<Vec3> fast = ply_velocities(folder / ("c/" + file + ".ply"), expected.places.size()),
                              velocities = ply_velocities(folder / ("m/" + file + ".ply"), start.size());
      for (std::size_t i = 0; i < expected.places.size(); ++i) {
        EXPECT_EQ(found.places[all->number[i]], expected.places[i]);
        EXPECT_EQ(velocities[all->number[i]], fast[i]);
      }
      for (const int i : all->unused) {
        EXPECT_EQ(found.places[i], start[i]);
        EXPECT_EQ(velocities[i], Vec3{});
      }
      const auto same = [&, body = all](const auto& theirs, auto ours) {
        for (auto& corners : ours) corners = numbers_in(*body, corners);
        EXPECT_EQ(theirs, ours);
      };
      same(found.faces, expected.faces), same(found.dots, expected.dots);
      for (const int i : numbers_in(*all, pins)) EXPECT_EQ(found.places[i], start[i]);
      if (frame == 2) {
        EXPECT_GT(length(found.places[all->number.back()] - start[all->number.back()]), 1e-3) << "it moves";
      }
    }
  }
}

TEST(FileVertices, OfFilesWithoutAnyThatNothingUsesCostNothing) {
  const TemporaryFolder folder;
  const Mesh sheet = mixed_sheet(3, true, 2);
  const Model model = build_model(parsed(swinging_file(folder.write("a.obj", obj_of(sheet)), {0})));
  ASSERT_EQ(model.render_mesh.vertices.size(), 1u);
  const FileVertices& file = model.render_mesh.vertices[0];
  EXPECT_TRUE(file.point.empty() && file.position.empty() && file.faces.empty());
  EXPECT_TRUE(model.notes.empty());
}

TEST(FileVertices, ThatNothingUsesCountInEveryFormatOfFramesAndAreDrawnByNone) {
  const TemporaryFolder folder;
  const Interspersed all = interspersed(mixed_sheet(3, false, 6), 7);
  Json scene = swinging_file(folder.write("a.obj", obj_of(all.mesh)), {all.number[0]});
  scene["outputs"]["frames"] = {{"every", 1}, {"formats", {"vtp", "pc2", "ply", "obj"}}};
  run_quietly(scene, {.out = folder / "out", .steps = 1});
  const std::string vtp = bytes_of(folder / "out/frames/frame_000001.vtp"),
                    count = std::to_string(all.mesh.points.size());
  EXPECT_TRUE(has(vtp, "NumberOfPoints=\"" + count + "\" NumberOfVerts=\"0\" NumberOfLines=\"0\""));
  const DrawnObj obj = drawn_file(folder / "out/frames/frame_000001.obj");
  EXPECT_TRUE(obj.dots.empty() && obj.lines.empty());
  EXPECT_EQ(obj.faces, corner_lists(all.mesh.faces));
  // Blender drops vertices that no element of rest.obj uses, and the samples must match the remaining ones.
  const DrawnObj rest = drawn_file(folder / "out/frames/rest.obj");
  std::vector<std::vector<int>> dots;
  for (const int i : all.unused) dots.push_back({i, i});
  EXPECT_EQ(rest.lines, dots);
  std::int32_t points = 0;
  std::memcpy(&points, bytes_of(folder / "out/frames/points_sheet.pc2").data() + 16, sizeof points);
  EXPECT_EQ(std::to_string(points), count);
}

TEST(FileVertices, AreToldByTheLibraryWhichParticlesTheyAre) {
  const TemporaryFolder folder;
  const Mesh sheet = mixed_sheet(3, true, 2);
  const Interspersed all = interspersed(sheet, 8);
  Json scene = swinging_file(folder.write("a.obj", obj_of(sheet)), {0});
  scene["bodies"].push_back(swinging_file(folder.write("b.obj", obj_of(all.mesh)), {all.number[0]})["bodies"][0]);
  scene["bodies"][1]["name"] = "second", scene["bodies"][1].erase("transform");
  const Simulation simulation(parsed(scene), {.threads = 1});
  const std::vector<int> first = simulation.particles_of_vertices(0), second = simulation.particles_of_vertices(1);
  for (int i = 0; i < static_cast<int>(sheet.points.size()); ++i) EXPECT_EQ(first.at(i), i);
  ASSERT_EQ(second.size(), all.mesh.points.size());
  const std::vector<Vec3> x = simulation.positions();
  for (const int i : all.number) EXPECT_EQ(x.at(second[i]), all.mesh.points[i]);
  for (const int i : all.unused) EXPECT_EQ(second[i], -1);
  EXPECT_THROW(simulation.particles_of_vertices(2), std::out_of_range);

  scene["outputs"]["frames"] = {{"every", 1}, {"formats", {"obj"}}};
  run_quietly(scene, {.out = folder / "out", .steps = 1});
  std::vector<Vec3> places = placed(sheet.points, scene);  // frames have the vertices of both files
  std::vector<std::vector<int>> faces = corner_lists(sheet.faces), more = corner_lists(all.mesh.faces);
  for (auto& corners : more)
    for (int& corner : corners) corner += static_cast<int>(places.size());
  faces.insert(faces.end(), more.begin(), more.end());
  places.insert(places.end(), all.mesh.points.begin(), all.mesh.points.end());
  const DrawnObj drawn = drawn_file(folder / "out/frames/frame_000000.obj");
  EXPECT_EQ(drawn.places, places);
  EXPECT_EQ(drawn.faces, faces);
}

/// A strip of 4 x 4 quads whose middle column is duplicated, as at a seam of UVs: 0 to 4 are that of the right half, 5
/// is unused, the others follow row by row. `apart`: distance of the two columns.
Mesh with_seam(double apart) {
  const Mesh whole = generate(GridShape{{1, 1}, {4, 4}});
  Mesh mesh;
  for (int j = 0; j < 5; ++j) mesh.points.push_back(whole.points[5 * j + 2]), mesh.points[j][1] += apart;
  mesh.points.push_back({0.3, 0.4, 0.5});
  mesh.points.insert(mesh.points.end(), whole.points.begin(), whole.points.end());
  for (const Quad& face : whole.faces) {
    double right = 0;
    for (const int corner : face) right += whole.points[corner][0] / 4;
    Quad& own = mesh.faces.emplace_back(face);
    for (int& corner : own) corner = right > 0.5 && corner % 5 == 2 ? corner / 5 : corner + 6;
  }
  return mesh;
}

TEST(FileVertices, ThatAreWeldedHaveOnePlaceAndKeepTheirFacesCorners) {
  for (const double apart : {0.0, 1e-5}) {
    const TemporaryFolder folder;
    const Mesh mesh = with_seam(apart);
    const auto run_with = [&](int pin, const std::string& out) {
      Json scene = swinging_file(folder.write("a.obj", obj_of(mesh)), {6, pin});
      scene["bodies"][0]["shape"]["weld"] = 2 * apart;
      scene["outputs"]["frames"] = {{"every", 5}, {"formats", {"obj"}}};
      run_quietly(scene, {.out = folder / out, .steps = 10});
      return scene;
    };
    const Json scene = run_with(1, "low");
    run_with(6 + 7, "high");
    const std::vector<Vec3> start = placed(mesh.points, scene);
    for (int frame = 0; frame <= 2; ++frame) {
      const std::string name = "frames/frame_00000" + std::to_string(frame) + ".obj";
      const DrawnObj drawn = drawn_file(folder / ("low/" + name)), same = drawn_file(folder / ("high/" + name));
      ASSERT_EQ(drawn.places.size(), mesh.points.size());
      EXPECT_EQ(drawn.faces, corner_lists(mesh.faces)) << "the seam stays";
      EXPECT_EQ(drawn.places, same.places) << "either vertex names the particle";
      for (int j = 0; j < 5; ++j) EXPECT_EQ(drawn.places[j], drawn.places[6 + 5 * j + 2]);
      EXPECT_EQ(drawn.places[5], start[5]);
      EXPECT_EQ(drawn.places[1], start[1]) << "pinned";
      if (frame == 2) {
        EXPECT_GT(length(drawn.places[0] - start[0]), 1e-3);
      }
    }
    const Model model = build_model(parsed(scene));
    const std::string keeps = "; pins, messages and frames keep the file's numbers";
    EXPECT_EQ(model.notes,
              (std::vector<std::string>{"body 'sheet': welded 5 vertices to others" + keeps,
                                        "body 'sheet': left out 1 vertex of no face, line or tetrahedron" + keeps}));
    const std::vector<int> particles = particles_of_vertices(model.render_mesh, 0);
    for (int j = 0; j < 5; ++j) EXPECT_EQ(particles[j], particles[6 + 5 * j + 2]);
    EXPECT_EQ(particle_name(model, particles[6 + 7]), "particle 1 of body 'sheet'") << "the lowest of its vertices";
    EXPECT_EQ(particle_name(model, particles[6]), "particle 6 of body 'sheet'");
  }
}

TEST(FileVertices, OfFacesThatWeldingClosesOrAreaTurnsKeepTheirCorners) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 0}};
  mesh.faces = {{4, 1, 2, 3}, {6, 4, 3, 5}};
  weld(mesh, 0, "a.obj");
  EXPECT_EQ(mesh.vertices.point, (std::vector<int>{0, 1, 2, 3, 0, 4, 0}));
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, 3}, {0, 3, 4, -1}}));
  EXPECT_EQ(mesh.vertices.faces, (std::vector<Quad>{{4, 1, 2, 3}, {6, 3, 5, -1}}));
  check_mesh(mesh, "a.obj", false);
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{1, 2, 3, 0}, {0, 3, 4, -1}}));
  EXPECT_EQ(mesh.vertices.faces, (std::vector<Quad>{{1, 2, 3, 4}, {6, 3, 5, -1}}));
}

TEST(FileVertices, ThatNothingUsesAreRefusedByPinsAndAttachments) {
  const TemporaryFolder folder;
  const Interspersed all = interspersed(mixed_sheet(2, false, 3), 9);
  const std::string file = folder.write("a.obj", obj_of(all.mesh));
  const auto said = [](const Json& scene) { return refusal([&] { build_model(parsed(scene)); }); };
  const std::string last = std::to_string(all.mesh.points.size() - 1);
  EXPECT_EQ(
      said(swinging_file(file, {all.number[0], 1})),
      "test.json: /bodies/0/pins/0: found particle 1, a vertex of no face, line or tetrahedron; allowed: vertices "
      "of faces, lines or tetrahedra");
  Json attached = swinging_file(file, {all.number[0]});
  attached["bodies"][0]["attachments"] = {{{"at", {{"particles", {std::stoi(last)}}}}, {"stiffness", 0.5}}};
  EXPECT_EQ(said(attached), "test.json: /bodies/0/attachments/0/at: found particle " + last +
                                ", a vertex of no face, line or tetrahedron; allowed: vertices of faces, lines or "
                                "tetrahedra");
  EXPECT_EQ(said(swinging_file(file, {std::stoi(last) + 1})), "test.json: /bodies/0/pins/0: found particle " +
                                                                  std::to_string(all.mesh.points.size()) +
                                                                  "; allowed: 0 to " + last);
}

TEST(FileVertices, AreNamedByTheirNumbersInMessages) {
  const TemporaryFolder folder;
  const Interspersed all = interspersed(mixed_sheet(2, false, 3), 9);
  const int corner = all.number[0], last = all.number.back();
  Json scene = swinging_file(folder.write("a.obj", obj_of(all.mesh)), {corner});
  const std::vector<Vec3> start = placed(all.mesh.points, scene);
  const auto said = [](const Json& of) { return refusal([&] { Simulation simulation(parsed(of), {.threads = 1}); }); };

  Json twice = scene;
  twice["bodies"][0]["pins"].push_back({{"particles", {corner}}, {"release_time", 1}});
  EXPECT_TRUE(has(said(twice), "found particle " + std::to_string(corner) + ", which another")) << said(twice);

  Json inside = scene;
  const auto at_last = [&](Json object) {
    object["name"] = "there", object["transform"]["translate"] = start[last];
    return Json::array({object});
  };
  inside["environment"] = at_last({{"shape", {{"sphere", {{"radius", 0.1}, {"subdivisions", 2}}}}}});
  EXPECT_TRUE(has(said(inside), "particle " + std::to_string(last) + " of body 'sheet', which starts")) << said(inside);

  Json behind = scene;
  behind["environment"] = at_last(
      {{"shape", {{"grid", {{"size", {0.2, 0.2}}, {"cells", {1, 1}}}}}}, {"sides", "one_sided"}, {"thickness", 0.04}});
  behind["environment"][0]["transform"]["translate"] = {start[last][0] - 0.1, start[last][1] + 0.05,
                                                        start[last][2] - 0.1};
  const Simulation under(parsed(behind), {.threads = 1});
  const std::string note = under.model().notes.back();
  EXPECT_TRUE(has(note, "behind the one-sided sheet 'there' (" + std::to_string(last) + " by ")) << note;

  Json expecting = scene;
  expecting["expect"]["bounds"] = {{"min", {start[last][0] - 0.01, -9, -9}}, {"max", {start[last][0] + 9, 9, 9}}};
  int lowest = -1;  // of the particles outside
  for (const int i : all.number)
    if (lowest < 0 && start[i][0] < start[last][0] - 0.01) lowest = i;
  const std::vector<std::string> failed_expectations =
      Simulation(parsed(expecting), {.threads = 1}).failed_expectations();
  ASSERT_EQ(failed_expectations.size(), 1u);
  EXPECT_TRUE(has(failed_expectations[0], "such as " + std::to_string(lowest) + " of body 'sheet' at"))
      << failed_expectations[0];

  Mesh again = all.mesh;  // a second vertex in one place
  again.faces.push_back(again.faces[0]);
  again.faces.back()[0] = static_cast<int>(again.points.size());
  again.points.push_back(again.points[last]);
  const std::string doubled = said(swinging_file(folder.write("b.obj", obj_of(again)), {corner}));
  EXPECT_TRUE(has(doubled, "vertex " + std::to_string(again.points.size() - 1) +
                               " (0-based): found the position of vertex " + std::to_string(last) + " again"))
      << doubled;
}

TEST(FileVertices, ThatNothingUsesGoWithABodyThatIsMovedOutOfASolid) {
  const TemporaryFolder folder;
  const Interspersed all = interspersed(mixed_sheet(2, false, 3), 9);
  Json scene = swinging_file(folder.write("a.obj", obj_of(all.mesh)), {0});
  scene["bodies"][0].erase("pins");
  const std::vector<Vec3> start = placed(all.mesh.points, scene);
  scene["environment"] = {{{"name", "ball"},
                           {"shape", {{"sphere", {{"radius", 0.1}, {"subdivisions", 2}}}}},
                           {"transform", {{"translate", start[all.number.back()]}}},
                           {"start_inside", "push_out"}}};
  scene["outputs"]["frames"] = {{"every", 1}, {"formats", {"obj"}}};
  run_quietly(scene, {.out = folder / "out", .steps = 1});
  const std::vector<Vec3> places = drawn_file(folder / "out/frames/frame_000000.obj").places;
  ASSERT_EQ(places.size(), start.size());
  const Vec3 moved = places[all.number[0]] - start[all.number[0]];
  EXPECT_GT(length(moved), 0.05);
  for (std::size_t i = 0; i < start.size(); ++i) EXPECT_LT(length(places[i] - start[i] - moved), 1e-12) << i;
}

TEST(FileVertices, OfAResumedRunAndItsPicturesAreThoseOfAWholeOne) {
  const TemporaryFolder folder;
  const Mesh sheet = mixed_sheet(3, true, 2);
  const Interspersed all = interspersed(sheet, 10);
  Json scene = swinging_file(folder.write("a.obj", obj_of(all.mesh)), {all.number[0]});
  Json clean = swinging_file(folder.write("clean.obj", obj_of(sheet)), {0});
  for (Json* one : {&scene, &clean}) {
    (*one)["outputs"]["pictures"] = {{"size", {64, 48}}};
    (*one)["outputs"]["frames"] = {{"every", 1}, {"formats", {"vtp", "pc2", "ply", "obj"}}};
  }
  run_quietly(scene, {.out = folder / "parts", .steps = 4});
  run_quietly(scene, {.out = folder / "parts", .steps = 10, .resume = true});
  run_quietly(scene, {.out = folder / "whole", .steps = 10});
  run_quietly(clean, {.out = folder / "clean", .steps = 10});
  auto parts = files_in(folder / "parts/frames"), whole = files_in(folder / "whole/frames");
  EXPECT_TRUE(parts == whole);
  EXPECT_EQ(drawn_obj(whole["rest.obj"]).places.size(), all.mesh.points.size());
  EXPECT_EQ(redraw(folder / "parts", 1), "");
  for (const char* name : {"picture.png", "storyboard.png"}) {
    EXPECT_FALSE(bytes_of(folder / "parts" / name).empty());
    EXPECT_TRUE(bytes_of(folder / "parts" / name) == bytes_of(folder / "clean" / name)) << "nothing more is drawn";
  }
}

TEST(FileVertices, ThatCountOtherwiseMakeAnotherSceneOfACheckpoint) {
  const TemporaryFolder folder;
  const Mesh sheet = mixed_sheet(3, true, 2);
  Mesh longer = sheet;
  longer.points.insert(longer.points.begin() + 5, Vec3{9, 9, 9});
  for (Quad& face : longer.faces)
    for (int& corner : face) corner += corner >= 5;
  const Json scene = swinging_file(folder.write("a.obj", obj_of(sheet)), {7});
  Simulation(parsed(scene), {.threads = 1}).save_checkpoint(folder / "checkpoint");
  folder.write("a.obj", obj_of(longer));
  Simulation other(parsed(scene), {.threads = 1});
  EXPECT_TRUE(has(refusal([&] { other.load_checkpoint(folder / "checkpoint"); }), "a checkpoint of another scene"));
}

TEST(FileVertices, ThatTearingAddsComeAfterAllOfTheFile) {
  const TemporaryFolder folder;
  const Mesh sheet = mixed_sheet(4, false, 11);  // its first row at z = 0, its last at z = 2
  const Interspersed all = interspersed(sheet, 12);
  const auto torn = [&](const std::string& file, const std::vector<int>& first, const std::vector<int>& last) {
    Json scene = swinging_file(file, first);
    scene["bodies"][0].erase("transform");
    scene["bodies"][0]["tear"] = {{"strain", 0.3}};
    scene["bodies"][0]["pins"].push_back(
        {{"particles", last}, {"motion", {{{"time", 0}}, {{"time", 0.4}, {"translate", {0, 0, 2}}}}}});
    scene["outputs"]["frames"] = {{"every", 20}, {"formats", {"obj"}}};
    return scene;
  };
  const std::vector<int> first{0, 1, 2, 3, 4}, last{40, 41, 42, 43, 44};
  run_quietly(torn(folder.write("clean.obj", obj_of(sheet)), first, last), {.out = folder / "clean", .steps = 20});
  run_quietly(torn(folder.write("a.obj", obj_of(all.mesh)), numbers_in(all, first), numbers_in(all, last)),
              {.out = folder / "out", .steps = 20});
  const std::size_t whole = sheet.points.size(), in_file = all.mesh.points.size();
  const DrawnObj expected = drawn_file(folder / "clean/frames/frame_000001.obj"),
                 found = drawn_file(folder / "out/frames/frame_000001.obj");
  ASSERT_GT(expected.places.size(), whole) << "it tore";
  std::vector<int> number = all.number;
  for (std::size_t k = 0; whole + k < expected.places.size(); ++k) number.push_back(static_cast<int>(in_file + k));
  ASSERT_EQ(found.places.size(), in_file + expected.places.size() - whole);
  for (std::size_t i = 0; i < number.size(); ++i) EXPECT_EQ(found.places[number[i]], expected.places[i]);
  for (const int i : all.unused) EXPECT_EQ(found.places[i], all.mesh.points[i]);
  auto faces = expected.faces;
  for (auto& corners : faces)
    for (int& corner : corners) corner = number[corner];
  EXPECT_EQ(found.faces, faces);
}

}  // namespace
}  // namespace malha
