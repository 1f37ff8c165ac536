// SPDX-License-Identifier: Apache-2.0
// Properties of real mesh files: vertices split at seams, unused vertices, and lines that continue.
#include "host/mesh/weld.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>
#include <string>

#include "host/mesh/generate.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "tests/constraints/mixed_sheet.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Every face with vertices of its own, moved by up to `off`, as in STL files and at seams of UV maps.
Mesh split_at_every_face(const Mesh& whole, double off, unsigned seed) {
  Random random(seed);
  Mesh mesh;
  for (Quad face : whole.faces) {
    for (int& corner : face) {
      if (corner < 0) continue;
      const Vec3& x = whole.points[corner];
      mesh.points.push_back({x[0] + random(-off, off), x[1] + random(-off, off), x[2] + random(-off, off)});
      corner = static_cast<int>(mesh.points.size()) - 1;
    }
    mesh.faces.push_back(face);
  }
  return mesh;
}

TEST(Weld, OfASurfaceSplitAtEveryFaceGivesTheSurfaceBack) {
  for (const Mesh& whole : {generate(SphereShape{1, 3}), generate(BoxShape{{1, 2, 3}, {{3, 4, 5}}})})
    for (const double off : {0.0, 1e-7}) {
      Mesh mesh = split_at_every_face(whole, off, 5);
      const int split = static_cast<int>(mesh.points.size());
      // Copies of a vertex lie within 2 sqrt(3) `off` of each other, different vertices some tenths apart.
      const Welded done = weld(mesh, 4 * off, "a.obj");
      ASSERT_EQ(mesh.points.size(), whole.points.size());
      EXPECT_EQ(done.merged, split - static_cast<int>(whole.points.size()));
      EXPECT_EQ(done.removed, 0);
      EXPECT_EQ(edges(mesh).size(), edges(whole).size());
      EXPECT_NO_THROW(require_closed(mesh, "a.obj", "a test"));
      EXPECT_NEAR(signed_volume(mesh.points, triangles(mesh)), signed_volume(whole.points, triangles(whole)), 1e-5);
    }
}

TEST(Weld, ClosesFacesWhoseCornersFallTogether) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1e-4}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2, 4}, {1, 2, 3, -1}, {0, 1, 3, 2}};
  mesh.lines = {{2, 3}, {0, 4}};
  const Welded done = weld(mesh, 1e-3, "a.obj");
  EXPECT_EQ(done.merged, 1);
  EXPECT_EQ(done.removed, 2) << "a triangle and a line";
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, 3}, {0, 1, 2, -1}}));
  EXPECT_EQ(mesh.lines, (std::vector<Edge>{{0, 3}}));
}

TEST(Weld, LeavesNoTwoVerticesWithinItsDistance) {
  Random random(3);
  Mesh mesh;
  for (int i = 0; i < 3000; ++i) mesh.points.push_back({random(), random(), 0.1 * random()});
  const Mesh before = mesh;
  const double distance = 0.03;
  weld(mesh, distance, "a.obj");
  EXPECT_LT(mesh.points.size(), before.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT(length(mesh.points[i] - mesh.points[j]), distance);
}

/// For each point the lowest one that it is transitively connected with, by comparing all pairs until nothing changes.
std::vector<int> lowest_of_connected_sets(const std::vector<Vec3>& points, double distance) {
  std::vector<int> lowest(points.size());
  std::iota(lowest.begin(), lowest.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < points.size(); ++j)
        if (lowest[j] < lowest[i] && length(points[i] - points[j]) <= distance) lowest[i] = lowest[j], changed = true;
  }
  return lowest;
}

TEST(Weld, MergesConnectedSetsInWhateverOrderTheVerticesStand) {
  Random random(4);
  std::vector<Vec3> points{{0, 0, 0}, {0.008, 0, 0}, {0.016, 0, 0}};  // a row: its ends are farther apart
  for (int i = 0; i < 400; ++i) points.push_back({1 + random(), random(), 0.1 * random()});
  for (int i = 0; i < 40; ++i) points.push_back({3 + 0.01 * random(), 0.02 * random(), 0});  // a crowd
  for (int order = 0; order < 6; ++order) {
    const std::vector<int> lowest = lowest_of_connected_sets(points, 0.01);
    Mesh mesh;
    mesh.points = points;
    weld(mesh, 0.01, "a.obj");
    ASSERT_LT(mesh.points.size(), points.size() - 20);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_EQ(mesh.points[mesh.vertices.point[i]], points[lowest[i]]) << i << ", order " << order;
    for (std::size_t i = points.size() - 1; i > 0; --i)
      std::swap(points[i], points[random.below(static_cast<int>(i) + 1)]);
  }
}

BodySpec of_file(const std::string& path, std::optional<double> weld) {
  BodySpec body;
  body.name = "model", body.shape = MeshFile{path, weld}, body.mass = 1;
  body.constraints = {compliant("distance", 1e-4, {"edges"})};
  return body;
}

TEST(MeshesFromFiles, AsBodiesHangAsTheirWholeWhenTheyAreWeldedAndUnusedVerticesAreLeftOut) {
  const TemporaryFolder folder;
  const Mesh whole = generate(GridShape{{1, 1}, {6, 6}});
  const Mesh split = split_at_every_face(whole, 0, 1);
  const std::string file = folder.write("a.obj", obj_of(split, "v 7 7 7\nv 8 8 8\n"));
  const auto hang = [&](BodySpec body) {
    body.pins = {BoxPin{{-1, -1, -0.01}, {2, 1, 0.01}}};
    return Simulation(scene_of({body}, kEarth, 0.01, 4), {.threads = 1});
  };
  EXPECT_THROW(hang(of_file(file, std::nullopt)), InputError);
  Simulation welded = hang(of_file(file, 0)), one = hang(of_file(folder.write("b.obj", obj_of(whole)), std::nullopt));
  ASSERT_EQ(welded.model().count(), 49);
  const std::vector<std::string>& notes = welded.model().notes;
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_TRUE(has(notes[0], "body 'model': welded 95 vertices to others")) << notes[0];  // 4 * 36 - 49
  EXPECT_TRUE(has(notes[1], "body 'model': left out 2 vertices of no face")) << notes[1];
  for (int step = 0; step < 50; ++step) welded.step(), one.step();
  double lowest[2] = {};
  for (const Vec3& x : welded.positions()) lowest[0] = std::min(lowest[0], x[1]);
  for (const Vec3& x : one.positions()) lowest[1] = std::min(lowest[1], x[1]);
  EXPECT_LT(lowest[1], -0.3);
  // The same constraints in another order: a sweep of four substeps differs by some percent at most.
  EXPECT_NEAR(lowest[0] / lowest[1], 1, 0.05);
}

TEST(MeshesFromFiles, AsEnvironmentMayHaveSplitAndUnusedVertices) {
  const TemporaryFolder folder;
  const Mesh split = split_at_every_face(generate(SphereShape{0.5, 3}), 0, 1);
  EnvironmentSpec ball;
  ball.name = "ball", ball.shape = MeshFile{folder.write("a.obj", obj_of(split, "v 0 9 0\n"))};
  Scene scene = scene_of({particle({0.01, 1, 0})}, kEarth, 0.01, 4);
  scene.environment = {ball};
  // it falls onto the object, and lies on it at a thickness, slightly tilted
  const Simulation simulation = after(scene, 0.4);
  EXPECT_NEAR(length(simulation.positions()[0]), 0.5 + ball.thickness, 5e-3);
}

TEST(MeshesFromFiles, LinesOfAnObjThatGoOnAreRead) {
  const TemporaryFolder folder;
  const Mesh mesh = read_mesh(folder.write("a.obj",
                                           "v 0 0 \\\n0\nv 1 0 0\r\nv 1 1 0\nvt 0 \\\n 0\nv 0 1 \\\r\n  \\\r\n 0\n"
                                           "# no line goes on from here \\\nf 1/1 2/2 \\\n   3 4\n"));
  EXPECT_EQ(mesh.points.size(), 4u);
  EXPECT_EQ(mesh.points[3], (Vec3{0, 1, 0}));
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, 3}}));
  try {
    read_mesh(folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 \\\n \\\n 3 oh\n"));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_TRUE(has(error.what(), "line 6, column 4")) << error.what();
  }
}

}  // namespace
}  // namespace malha
