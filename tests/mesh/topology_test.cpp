// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/topology.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "host/mesh/generate.h"
#include "tests/mesh/mesh_files.h"

namespace malha {
namespace {

Mesh mesh_of_faces(const std::vector<Vec3>& points, const std::vector<Quad>& faces) {
  Mesh mesh;
  mesh.points = points;
  mesh.faces = faces;
  return mesh;
}

// The same surface with its points renumbered and its faces in another order, both at random.
Mesh shuffled(const Mesh& mesh) {
  std::mt19937 random(7);
  std::vector<int> number(mesh.points.size());
  std::iota(number.begin(), number.end(), 0);
  std::ranges::shuffle(number, random);
  Mesh result = mesh;
  for (std::size_t i = 0; i < number.size(); ++i) result.points[number[i]] = mesh.points[i];
  for (Quad& face : result.faces) {
    for (int& corner : face) corner = corner < 0 ? corner : number[corner];
  }
  std::ranges::shuffle(result.faces, random);
  return result;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(Edges, ComeOnceInTheOrderOfFirstAppearanceThenLines) {
  Mesh mesh;
  mesh.points.resize(7);
  mesh.faces = {{3, 2, 1, -1}, {1, 2, 0, 4}};
  mesh.lines = {{5, 4}, {2, 3}, {4, 5}, {6, 6}, {5, 6}};
  EXPECT_EQ(edges(mesh), (std::vector<Edge>{{2, 3}, {1, 2}, {1, 3}, {0, 2}, {0, 4}, {1, 4}, {4, 5}, {5, 6}}));
}

TEST(Edges, AgreeWithAPlainSetOnAShuffledMesh) {
  const Mesh mesh = shuffled(generate(SphereShape{1, 3}));
  std::set<Edge> seen;
  std::vector<Edge> expected;
  for (const auto& [a, b, c, none] : mesh.faces) {
    for (const auto& [from, to] : {Edge{a, b}, {b, c}, {c, a}}) {
      const Edge edge{std::min(from, to), std::max(from, to)};
      if (seen.insert(edge).second) expected.push_back(edge);
    }
  }
  EXPECT_EQ(edges(mesh), expected);
}

TEST(Edges, OfAGridAreCountedByFormula) {
  EXPECT_EQ(edges(generate(GridShape{{1, 1}, {7, 4}})).size(), 7u * 5u + 8u * 4u);
  EXPECT_TRUE(edges(Mesh{}).empty());
}

TEST(Edges, OfAFanAboutOnePointAreFound) {
  const int spokes = 100'000;  // quadratic work about the hub would take minutes
  Mesh fan;
  fan.points.resize(spokes + 1);
  for (int i = 0; i < spokes; ++i) fan.faces.push_back({0, i + 1, (i + 1) % spokes + 1, -1});
  EXPECT_EQ(edges(fan).size(), 2u * spokes);
  EXPECT_EQ(hinges(fan).size(), std::size_t{spokes});
}

TEST(Shear, IsBothDiagonalsOfEveryQuad) {
  Mesh mesh;
  mesh.points.resize(7);
  mesh.faces = {{0, 1, 2, 3}, {1, 4, 2, -1}, {4, 5, 6, 2}};
  EXPECT_EQ(shear(mesh), (std::vector<Edge>{{0, 2}, {1, 3}, {4, 6}, {5, 2}}));
}

TEST(Triangles, SplitQuadsAlongTheirFirstDiagonal) {
  Mesh mesh;
  mesh.points.resize(5);
  mesh.faces = {{0, 1, 2, 3}, {1, 4, 2, -1}};
  EXPECT_EQ(triangles(mesh), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}));
}

TEST(Hinges, HoldTheSharedEdgeAndTheTwoOppositeCorners) {
  Mesh mesh;
  mesh.points.resize(5);
  mesh.faces = {{0, 1, 2, 3}, {1, 4, 2, -1}};
  EXPECT_EQ(hinges(mesh), (std::vector<std::array<int, 4>>{{1, 2, 0, 4}, {2, 0, 1, 3}}));
}

TEST(Hinges, OfAGridAreCountedByFormula) {
  const int nx = 7, nz = 4;  // a diagonal in each cell, and the edges between cells
  const auto found = hinges(generate(GridShape{{1, 1}, {nx, nz}}));
  EXPECT_EQ(static_cast<int>(found.size()), nx * nz + nx * (nz - 1) + nz * (nx - 1));
}

TEST(Hinges, LieBetweenTwoTrianglesInTheirOrientation) {
  for (const Mesh& mesh : {shuffled(generate(SphereShape{1, 2})), shuffled(generate(BoxShape{}))}) {
    std::set<Triangle> all;
    for (const auto& [a, b, c] : triangles(mesh))
      all.insert({{a, b, c}}), all.insert({{b, c, a}}), all.insert({{c, a, b}});
    const auto found = hinges(mesh);
    EXPECT_EQ(found.size(), triangles(mesh).size() * 3 / 2);  // closed: every edge is one
    std::set<Edge> edges_found;
    for (const auto& [a, b, c, d] : found) {
      EXPECT_TRUE(all.contains({a, b, c}));
      EXPECT_TRUE(all.contains({b, a, d}));
      EXPECT_TRUE(edges_found.insert({std::min(a, b), std::max(a, b)}).second);
    }
  }
}

TEST(Hinges, LeaveOutBordersAndCrowdedEdges) {
  Mesh mesh;
  mesh.points.resize(5);
  mesh.faces = {{0, 1, 2, -1}};
  EXPECT_TRUE(hinges(mesh).empty());
  for (const Quad& other : {Quad{1, 0, 3, -1}, Quad{0, 1, 3, -1}}) {  // wound alike, and against each other
    mesh.faces = {{0, 1, 2, -1}, other};
    EXPECT_EQ(hinges(mesh), (std::vector<std::array<int, 4>>{{0, 1, 2, 3}}));
  }
  mesh.faces.push_back({1, 0, 4, -1});
  int non_manifold = 0;
  EXPECT_TRUE(hinges(mesh, &non_manifold).empty());
  EXPECT_EQ(non_manifold, 1);
}

TEST(Components, AreNumberedByTheirLowestParticles) {
  int count = 0;
  EXPECT_EQ(components(7, {{5, 1}, {6, 4}, {1, 3}, {4, 0}}, count), (std::vector<int>{0, 1, 2, 1, 0, 1, 0}));
  EXPECT_EQ(count, 3);
  EXPECT_EQ(components(3, {}, count), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(count, 3);
  EXPECT_TRUE(components(0, {}, count).empty());
  EXPECT_EQ(count, 0);
}

TEST(Components, OfAConnectedMeshAreOne) {
  const Mesh mesh = shuffled(generate(SphereShape{1, 4}));
  int count = 0;
  const auto labels = components(static_cast<int>(mesh.points.size()), edges(mesh), count);
  EXPECT_EQ(count, 1);
  EXPECT_EQ(std::ranges::count(labels, 0), static_cast<long>(mesh.points.size()));
}

TEST(SignedVolume, IsThatOfATetrahedronAndItsMirrorImage) {
  const std::vector<Vec3> points(tetrahedron, tetrahedron + 4);
  EXPECT_DOUBLE_EQ(signed_volume(points, triangles(mesh_of_faces(points, tetrahedron_faces))), 1.0 / 6);
  std::vector<Quad> inside_out = tetrahedron_faces;
  for (Quad& face : inside_out) std::swap(face[0], face[1]);
  EXPECT_DOUBLE_EQ(signed_volume(points, triangles(mesh_of_faces(points, inside_out))), -1.0 / 6);
}

TEST(SignedVolume, KeepsItsDigitsFarFromTheOrigin) {
  Mesh box = generate(BoxShape{{1, 2, 4}, {{2, 2, 2}}});
  for (Vec3& point : box.points) {
    for (double& value : point) value += 1 << 30;  // exact: the sizes are powers of two
  }
  EXPECT_EQ(signed_volume(box.points, triangles(box)), 8);
}

TEST(MassesByDensity, GiveCornersAThirdOfATriangleAndEndsAHalfOfALine) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {2, 0, 5}, {9, 9, 9}};
  mesh.faces = {{0, 1, 2, -1}};  // 3 m^2
  mesh.lines = {{1, 3}};         // 5 m
  const std::vector<double> expected{2, 7, 2, 5, 0};
  const std::vector<double> masses = masses_by_density(mesh, 2);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_DOUBLE_EQ(masses[i], expected[i]);
}

TEST(MassesByDensity, TreatAllCornersOfAQuadAlike) {
  // A kite, symmetric about the diagonal 1-3 only: each single split would tell 0 from 2, or 1 and 3 from them.
  const std::vector<Vec3> kite{{-1, 0, 0}, {0, -2, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<double> masses = masses_by_density(mesh_of_faces(kite, {{0, 1, 2, 3}}), 12);
  // Areas: 2 below and 1 above the diagonal 0-2, 1.5 on either side of 1-3. Density 12: a corner gets 2 for each m^2 of
  // its triangles in both splits.
  const std::vector<double> expected{2 * (3 + 1.5), 2 * (2 + 3), 2 * (3 + 1.5), 2 * (1 + 3)};
  for (int i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(masses[i], expected[i]);
  for (int turn = 1; turn < 4; ++turn) {  // for every choice of the first corner
    const Quad turned{turn, (turn + 1) % 4, (turn + 2) % 4, (turn + 3) % 4};
    const std::vector<double> again = masses_by_density(mesh_of_faces(kite, {turned}), 12);
    for (int i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(again[i], masses[i]);
  }
}

TEST(MassesByDensity, OfAConcaveQuadAreThoseOfItsArea) {
  const std::vector<Vec3> dart{{0, 0, 0}, {2, 0, 0}, {0.3, 0.3, 0}, {0, 2, 0}};
  for (int turn = 0; turn < 4; ++turn) {
    const Quad turned{turn, (turn + 1) % 4, (turn + 2) % 4, (turn + 3) % 4};
    const std::vector<double> masses = masses_by_density(mesh_of_faces(dart, {turned}), 2);
    // The large triangle of 2 m^2 without the one of 1.4 m^2 that the third corner cuts off.
    EXPECT_NEAR(sum(masses), 2 * 0.6, 1e-14);
    double moment = 0;
    for (int i = 0; i < 4; ++i) moment += masses[i] * dart[i][0];
    EXPECT_NEAR(moment, 2 * (2 * (2.0 / 3) - 1.4 * (2.3 / 3)), 1e-14);
  }
}

// A corner's triangle, which the diagonal between its neighbours cuts off, is in one of the two splits, and the whole
// area in the other: the corner gets a sixth of both together. With a triangle's masses the corners have its centroid,
// so that a flat quad's have the quad's.
TEST(MassesByDensity, GiveACornerOfAQuadASixthOfItsAreaAndOfTheCornersTriangle) {
  const double a = 3, b = 1, h = 2, lean = 0.5, density = 1.7;  // a trapezoid: sides a and b in parallel, h apart
  const std::vector<Vec3> trapezoid{{0, 0, 0}, {a, 0, 0}, {lean + b, h, 0}, {lean, h, 0}};
  const std::vector<double> masses = masses_by_density(mesh_of_faces(trapezoid, {{0, 1, 2, 3}}), density);
  const double area = h * (a + b) / 2, at_long = a * h / 2, at_short = b * h / 2;
  for (const int corner : {0, 1}) EXPECT_NEAR(masses[corner], density * (area + at_long) / 6, 1e-14);
  for (const int corner : {2, 3}) EXPECT_NEAR(masses[corner], density * (area + at_short) / 6, 1e-14);
  EXPECT_NEAR(sum(masses), density * area, 1e-14);
  double height = 0;
  for (int i = 0; i < 4; ++i) height += masses[i] * trapezoid[i][1] / (density * area);
  EXPECT_NEAR(height, h / 3 * (a + 2 * b) / (a + b), 1e-14) << "the centre of a trapezoid";
}

TEST(MassesByDensity, OfAGridAreThoseOfItsCells) {
  const std::vector<double> masses = masses_by_density(generate(GridShape{{4, 6}, {4, 3}}), 3);  // cells of 1 m x 2 m
  EXPECT_DOUBLE_EQ(masses[0], 6.0 / 4);
  EXPECT_DOUBLE_EQ(masses[1], 6.0 / 2);
  EXPECT_DOUBLE_EQ(masses[6], 6.0);
  EXPECT_NEAR(sum(masses), 3 * 24, 1e-12);
}

TEST(MassesByTotal, AddUpAndKeepTheProportions) {
  const Mesh mesh = generate(SphereShape{0.5, 3});
  const std::vector<double> by_total = masses_by_total(mesh, 2.5), by_density = masses_by_density(mesh, 1);
  EXPECT_NEAR(sum(by_total), 2.5, 1e-13);  // rounding of 642 terms
  const double ratio = by_total[0] / by_density[0];
  for (std::size_t i = 0; i < by_total.size(); ++i) EXPECT_NEAR(by_total[i] / by_density[i], ratio, 1e-12 * ratio);
}

TEST(MassesByTotal, GiveLoosePointsEqualShares) {
  for (const double mass : masses_by_total(generate(LatticeShape{}), 4)) EXPECT_DOUBLE_EQ(mass, 0.5);
  Mesh mixed = generate(ChainShape{{0, 0, 0}, {2, 0, 0}, 2});
  mixed.points.push_back({5, 5, 5});
  const std::vector<double> expected{0.75, 1.5, 0.75, 1};
  const std::vector<double> masses = masses_by_total(mixed, 4);
  for (int i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(masses[i], expected[i]);
}

std::string closed_refusal(const Mesh& mesh) {
  return refusal([&] { require_closed(mesh, "balloon.obj", "pressure needs a closed mesh"); });
}
const std::string two_faces =
    "; allowed: pressure needs a closed mesh: every edge with exactly two faces, consistently oriented";

Mesh closed_tetrahedron() { return mesh_of_faces({tetrahedron, tetrahedron + 4}, tetrahedron_faces); }

TEST(RequireClosed, AcceptsClosedSurfacesSeenFromOutside) {
  EXPECT_EQ(closed_refusal(closed_tetrahedron()), "");
  EXPECT_EQ(closed_refusal(shuffled(generate(BoxShape{}))), "");
}

TEST(RequireClosed, RefusesAnOpenMeshAndNamesAnEdge) {
  Mesh mesh = closed_tetrahedron();
  mesh.faces.pop_back();
  EXPECT_EQ(closed_refusal(mesh),
            "balloon.obj: edge 0-2 (vertices, 0-based): found an open edge, with one face only (edges like it: 3)" +
                two_faces);
}

TEST(RequireClosed, RefusesAnEdgeWithMoreThanTwoFaces) {
  Mesh mesh = closed_tetrahedron();  // and its mirror image in the plane z = 0: they touch in the edges of that plane
  mesh.points.push_back({0, 0, -1});
  for (const Quad& face : tetrahedron_faces) mesh.faces.push_back({face[1], face[0], face[2] == 3 ? 4 : face[2], -1});
  EXPECT_EQ(closed_refusal(mesh),
            "balloon.obj: edge 0-2 (vertices, 0-based): found an edge with more than two faces (edges like it: 3)" +
                two_faces);
}

TEST(RequireClosed, RefusesNeighboursOrientedAgainstEachOther) {
  Mesh mesh = closed_tetrahedron();
  std::swap(mesh.faces[3][0], mesh.faces[3][1]);
  EXPECT_EQ(closed_refusal(mesh),
            "balloon.obj: edge 0-2 (vertices, 0-based): found an edge whose two faces have opposite orientations "
            "(edges like it: 3)" +
                two_faces);
}

TEST(RequireClosed, RefusesAMeshInsideOut) {
  Mesh mesh = generate(BoxShape{{1, 2, 3}, {{1, 1, 1}}});
  for (Quad& face : mesh.faces) std::ranges::reverse(face);
  EXPECT_EQ(
      closed_refusal(mesh),
      "balloon.obj: found an enclosed volume of -6 m^3 (inside out); allowed: pressure needs a closed mesh: faces "
      "counter-clockwise seen from outside, so that the volume is positive");
}

TEST(RequireClosed, RefusesAMeshWithoutFaces) {
  EXPECT_EQ(closed_refusal(generate(ChainShape{})), "balloon.obj: found a mesh without faces" + two_faces);
}

}  // namespace
}  // namespace malha
