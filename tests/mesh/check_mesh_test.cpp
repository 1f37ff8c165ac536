// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/check_mesh.h"

#include <cmath>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "tests/mesh/mesh_files.h"

namespace malha {
namespace {

std::string refused(Mesh mesh, bool loose_points_allowed = false) {
  const Mesh before = mesh;
  std::string said = refusal([&] { check_mesh(mesh, "a.obj", loose_points_allowed); });
  EXPECT_EQ(mesh.faces, before.faces) << "a refused mesh is unchanged";
  return said;
}

// A unit square of two triangles; its bounding box's diagonal is sqrt(2).
Mesh square() {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2, -1}, {0, 2, 3, -1}};
  return mesh;
}

Mesh with_faces(const std::vector<Vec3>& points, const std::vector<Quad>& faces) {
  Mesh mesh;
  mesh.points = points;
  mesh.faces = faces;
  return mesh;
}

TEST(CheckMesh, LeavesAGoodMeshAlone) {
  for (const Mesh& good : {square(), generate(SphereShape{}), generate(BoxShape{}), generate(ChainShape{})}) {
    Mesh mesh = good;
    EXPECT_EQ(check_mesh(mesh, "a.obj", false), 0);
    EXPECT_EQ(mesh.points, good.points);
    EXPECT_EQ(mesh.faces, good.faces);
    EXPECT_EQ(mesh.lines, good.lines);
  }
}

TEST(CheckMesh, RemovesAndCountsTrianglesWithoutArea) {
  Mesh mesh = square();
  mesh.points.push_back({0.5, 0.5, 0});  // on the diagonal
  mesh.faces = {{0, 0, 1, -1}, {0, 1, 4, -1}, {2, 4, 0, -1}, {1, 2, 4, -1},
                {3, 2, 3, -1}, {0, 4, 3, -1}, {4, 2, 3, -1}};
  EXPECT_EQ(check_mesh(mesh, "a.obj", false), 3);
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 4, -1}, {1, 2, 4, -1}, {0, 4, 3, -1}, {4, 2, 3, -1}}));
}

TEST(CheckMesh, MeasuresZeroByTheBoundingBox) {
  // The limit for a diagonal of sqrt(2) is an area of 2e-12; the sliver (0, 1, 4) has half its height.
  for (const double scale : {1.0, 1e-6, 1e6}) {
    for (const auto& [height, removed] : {std::pair{3.9e-12, 1}, {4.1e-12, 0}}) {
      Mesh mesh = square();
      mesh.points.push_back({0.5, height, 0});
      mesh.faces.push_back({0, 1, 4, -1});
      mesh.lines.push_back({3, 4});  // keeps vertex 4 from being loose
      for (Vec3& point : mesh.points) {
        for (double& value : point) value *= scale;
      }
      EXPECT_EQ(check_mesh(mesh, "a.obj", false), removed) << scale << ' ' << height;
      EXPECT_EQ(mesh.faces.size(), 3u - removed);
    }
  }
}

TEST(CheckMesh, CutsAQuadWithARepeatedCornerDownToATriangle) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const Quad& face : {Quad{0, 0, 1, 2}, {0, 1, 1, 2}, {0, 1, 2, 2}, {0, 1, 2, 0}}) {
    Mesh mesh = with_faces(points, {face});
    EXPECT_EQ(check_mesh(mesh, "a.obj", false), 1);
    EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, -1}}));
  }
}

TEST(CheckMesh, RemovesQuadsWithoutAreaAndFoldedOnes) {
  for (const Quad& face : {Quad{0, 0, 1, 1}, {0, 1, 0, 1}, {0, 1, 4, 5}, {0, 1, 0, 2}, {0, 1, 2, 1}}) {
    Mesh mesh = square();
    mesh.points.insert(mesh.points.end(), {{2, 0, 0}, {3, 0, 0}});
    mesh.faces.push_back({4, 5, 2, -1});
    mesh.faces.push_back(face);
    EXPECT_EQ(check_mesh(mesh, "a.obj", false), 1);
    EXPECT_EQ(mesh.faces, (std::vector<Quad>{{0, 1, 2, -1}, {0, 2, 3, -1}, {4, 5, 2, -1}}));
  }
}

TEST(CheckMesh, RenumbersAQuadWithAStraightCornerAndKeepsItsEdges) {
  // A triangle 0, 2, 3 whose side 0-2 has vertex 1 in its middle.
  Mesh mesh = with_faces({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, {{0, 1, 2, 3}});
  const auto before = edges(mesh).size();
  EXPECT_EQ(check_mesh(mesh, "a.obj", false), 0);
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{1, 2, 3, 0}}));
  EXPECT_EQ(edges(mesh).size(), before);
  EXPECT_EQ(check_mesh(mesh, "a.obj", false), 0);  // both halves have an area now
  EXPECT_EQ(mesh.faces, (std::vector<Quad>{{1, 2, 3, 0}}));
}

TEST(CheckMesh, RefusesCoordinatesThatCannotBeSimulated) {
  for (const auto& [value, text] :
       {std::pair{std::nan(""), "nan"}, {HUGE_VAL, "inf"}, {-HUGE_VAL, "-inf"}, {2e12, "2e+12"}}) {
    Mesh mesh = square();
    mesh.points[2][1] = value;
    EXPECT_EQ(refused(mesh), std::string("a.obj: vertex 2 (0-based): found the coordinate ") + text +
                                 "; allowed: finite numbers up to 1e12 m");
  }
}

TEST(CheckMesh, RefusesVerticesInTheSamePlace) {
  Mesh mesh = square();
  mesh.points.push_back({-0.0, 1, 0});  // vertex 3 again
  mesh.points.push_back({1, 0, 0});
  mesh.faces.push_back({4, 5, 0, -1});
  const std::string allowed =
      "; allowed: one vertex for each position: \"weld\": 0 beside the \"mesh\" of a body merges them (or Blender's "
      "Merge by Distance)";
  EXPECT_EQ(refused(mesh),
            "a.obj: vertex 4 (0-based): found the position of vertex 3 again (vertices like it: 2)" + allowed);
  EXPECT_EQ(refused(mesh, true), refused(mesh));
}

TEST(CheckMesh, RefusesRepeatedFacesWhateverTheirOrder) {
  for (const Quad& again : {Quad{0, 1, 2, -1}, {1, 2, 0, -1}, {2, 1, 0, -1}}) {
    Mesh mesh = square();
    mesh.faces.insert(mesh.faces.begin() + 1, {3, 3, 1, -1});  // it is removed, but counts in face numbers
    mesh.faces.push_back(again);
    const std::string corners =
        std::to_string(again[0]) + ", " + std::to_string(again[1]) + ", " + std::to_string(again[2]);
    EXPECT_EQ(refused(mesh),
              "a.obj: face 3 (0-based): found the vertices " + corners + " of face 0 again; allowed: every face once");
  }
  Mesh quads = generate(GridShape{{1, 1}, {2, 1}});
  quads.faces.push_back({quads.faces[1][2], quads.faces[1][1], quads.faces[1][0], quads.faces[1][3]});
  EXPECT_EQ(refused(quads),
            "a.obj: face 2 (0-based): found the vertices 5, 4, 1, 2 of face 1 again; allowed: every face once");
}

TEST(CheckMesh, RefusesIsolatedVerticesUnlessLoosePointsAreAllowed) {
  Mesh mesh = square();
  mesh.points.push_back({5, 5, 5});
  mesh.points.push_back({6, 5, 5});
  EXPECT_EQ(refused(mesh),
            "a.obj: vertex 4 (0-based): found a vertex of no face, line or tetrahedron (vertices like it: 2); allowed: "
            "vertices of "
            "faces with an area, or of lines");
  EXPECT_EQ(refused(mesh, true), "");
  EXPECT_EQ(refused(generate(LatticeShape{}), true), "");
  mesh.lines.push_back({4, 5});
  EXPECT_EQ(refused(mesh), "");
}

TEST(CheckMesh, SaysSoWhereAVertexLosesItsLastFace) {
  Mesh mesh = square();
  mesh.points.push_back({0.5, 0, 0});
  mesh.faces.push_back({0, 4, 1, -1});
  EXPECT_EQ(
      refused(mesh),
      "a.obj: vertex 4 (0-based): found a vertex whose faces all have zero area; allowed: vertices of faces with an "
      "area, or of lines");
}

TEST(CheckMesh, RefusesALineFromAVertexToItself) {
  Mesh mesh = generate(ChainShape{{0, 0, 0}, {1, 0, 0}, 3});
  mesh.lines.push_back({2, 2});
  EXPECT_EQ(refused(mesh), "a.obj: line 3 (0-based): found vertex 2 at both ends; allowed: two vertices");
}

}  // namespace
}  // namespace malha
