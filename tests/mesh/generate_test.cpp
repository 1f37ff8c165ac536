// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/generate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "host/mesh/check_mesh.h"
#include "host/mesh/topology.h"
#include "tests/mesh/mesh_files.h"

namespace malha {
namespace {

double area(const Mesh& mesh) {
  const std::vector<double> masses = masses_by_density(mesh, 1);
  return std::accumulate(masses.begin(), masses.end(), 0.0);
}

double enclosed_volume(const Mesh& mesh) { return signed_volume(mesh.points, triangles(mesh)); }

long euler_characteristic(const Mesh& mesh) {
  return static_cast<long>(mesh.points.size()) - static_cast<long>(edges(mesh).size()) +
         static_cast<long>(mesh.faces.size());
}

// No element is degenerate, duplicated or unused.
void expect_clean(Mesh mesh) {
  const Mesh before = mesh;
  EXPECT_EQ(check_mesh(mesh, "generated", false), 0);
  EXPECT_EQ(mesh.faces, before.faces);
}

TEST(GenerateGrid, NumbersXFastestInThePlaneYZero) {
  const Mesh grid = generate(GridShape{{3, 1}, {3, 2}});
  const std::vector<Vec3> expected{{0, 0, 0},   {1, 0, 0},   {2, 0, 0}, {3, 0, 0}, {0, 0, 0.5}, {1, 0, 0.5},
                                   {2, 0, 0.5}, {3, 0, 0.5}, {0, 0, 1}, {1, 0, 1}, {2, 0, 1},   {3, 0, 1}};
  EXPECT_EQ(grid.points, expected);
  ASSERT_EQ(grid.faces.size(), 6u);
  EXPECT_EQ(grid.faces[0], (Quad{0, 4, 5, 1}));
  EXPECT_EQ(grid.faces[4], (Quad{5, 9, 10, 6}));
  EXPECT_TRUE(grid.lines.empty());
}

TEST(GenerateGrid, IsADiskOfQuadsThatFaceUp) {
  const Mesh grid = generate(GridShape{{0.7, 1.3}, {17, 5}});
  expect_clean(grid);
  EXPECT_EQ(grid.faces.size(), 17u * 5u);
  EXPECT_EQ(euler_characteristic(grid), 1);
  EXPECT_NEAR(area(grid), 0.7 * 1.3, 1e-14);  // rounding of 170 triangles
  for (const auto& [a, b, c] : triangles(grid)) {
    const Vec3 &p = grid.points[a], &q = grid.points[b], &r = grid.points[c];
    EXPECT_GT((q[2] - p[2]) * (r[0] - p[0]) - (q[0] - p[0]) * (r[2] - p[2]), 0);  // y of (q - p) x (r - p)
  }
}

TEST(GenerateSphere, SharesMidpointsAndClosesOutwards) {
  for (int n = 0; n <= 4; ++n) {
    const Mesh sphere = generate(SphereShape{0.25, n});
    EXPECT_EQ(sphere.points.size(), 10u * (1u << 2 * n) + 2u);
    EXPECT_EQ(sphere.faces.size(), 20u * (1u << 2 * n));
    EXPECT_EQ(euler_characteristic(sphere), 2);
    expect_clean(sphere);
    EXPECT_NO_THROW(require_closed(sphere, "sphere", "test"));
    for (const Vec3& p : sphere.points) EXPECT_NEAR(std::hypot(p[0], p[1], p[2]), 0.25, 1e-16);  // one rounding
  }
}

TEST(GenerateSphere, ConvergesFromBelow) {
  const double radius = 2, exact_volume = 4.0 / 3 * std::numbers::pi * 8, exact_area = 4 * std::numbers::pi * 4;
  double volume_before = 0, area_before = 0;
  for (int n = 0; n <= 5; ++n) {
    const Mesh sphere = generate(SphereShape{radius, n});
    const double volume_error = exact_volume - enclosed_volume(sphere), area_error = exact_area - area(sphere);
    EXPECT_GT(volume_error, 0);
    EXPECT_GT(area_error, 0);
    if (n > 2) {  // second order, once fine: half the edge length, a quarter of the error
      EXPECT_NEAR(volume_before / volume_error, 4, 0.1);
      EXPECT_NEAR(area_before / area_error, 4, 0.1);
    }
    volume_before = volume_error, area_before = area_error;
  }
}

TEST(GenerateSphere, StartsFromTheIcosahedron) {
  const Mesh icosahedron = generate(SphereShape{1, 0});
  const double edge = 1 / std::sin(2 * std::numbers::pi / 5);  // of the icosahedron of circumradius 1
  for (const auto& [a, b] : edges(icosahedron)) {
    const Vec3 &p = icosahedron.points[a], &q = icosahedron.points[b];
    EXPECT_NEAR(std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]), edge, 1e-15);
  }
}

TEST(GenerateBox, IsAClosedSurfaceOfQuadsWhateverTheCells) {
  for (const auto& cells : {std::array{1, 1, 1}, {1, 3, 2}, {4, 1, 1}, {2, 2, 2}, {3, 4, 5}, {1, 1, 6}}) {
    const auto [x, y, z] = cells;
    const Mesh box = generate(BoxShape{{1.5, 0.5, 2}, cells});
    EXPECT_EQ(static_cast<int>(box.faces.size()), 2 * (x * y + y * z + z * x));
    EXPECT_EQ(static_cast<int>(box.points.size()), (x + 1) * (y + 1) * (z + 1) - (x - 1) * (y - 1) * (z - 1));
    EXPECT_EQ(euler_characteristic(box), 2);
    expect_clean(box);
    EXPECT_NO_THROW(require_closed(box, "box", "test"));
    EXPECT_NEAR(enclosed_volume(box), 1.5, 1e-14);
    EXPECT_NEAR(area(box), 2 * (1.5 * 0.5 + 0.5 * 2 + 2 * 1.5), 1e-14);
    EXPECT_EQ(box.points.front(), (Vec3{-0.75, -0.25, -1}));
    EXPECT_EQ(box.points.back(), (Vec3{0.75, 0.25, 1}));
    const auto zyx_less = [](const Vec3& a, const Vec3& b) {
      return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
    };
    EXPECT_TRUE(std::ranges::is_sorted(box.points, zyx_less));  // x fastest, then y, then z
  }
}

TEST(GenerateBar, LiesAlongXWithSquareCells) {
  const Mesh bar = generate(BarShape{1, 0.1, 2});
  EXPECT_EQ(bar.faces.size(), 4u * 20u * 2u + 2u * 4u);
  EXPECT_NO_THROW(require_closed(bar, "bar", "test"));
  EXPECT_NEAR(enclosed_volume(bar), 0.01, 1e-16);
  EXPECT_EQ(bar.points.front(), (Vec3{0, -0.05, -0.05}));
  EXPECT_EQ(bar.points.back(), (Vec3{1, 0.05, 0.05}));
  for (const auto& [a, b] : edges(bar)) {
    const Vec3 &p = bar.points[a], &q = bar.points[b];
    EXPECT_NEAR(std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]), 0.05, 1e-15);
  }
}

TEST(GenerateBar, TakesTheNearestNumberOfCellsAndAtLeastOne) {
  EXPECT_EQ(generate(BarShape{1.04, 0.1, 1}).faces.size(), 4u * 10u + 2u);
  EXPECT_EQ(generate(BarShape{1.06, 0.1, 1}).faces.size(), 4u * 11u + 2u);
  EXPECT_EQ(generate(BarShape{0.01, 0.1, 1}).faces.size(), 6u);
}

TEST(GenerateChain, RunsInEqualStepsFromEndToEndExactly) {
  const Mesh chain = generate(ChainShape{{1, 2, 3}, {1.1, 0, 3}, 7});
  ASSERT_EQ(chain.points.size(), 8u);
  EXPECT_EQ(chain.points.front(), (Vec3{1, 2, 3}));
  EXPECT_EQ(chain.points.back(), (Vec3{1.1, 0, 3}));
  EXPECT_TRUE(chain.faces.empty());
  ASSERT_EQ(chain.lines.size(), 7u);
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(chain.lines[i], (Edge{i, i + 1}));
    EXPECT_NEAR(chain.points[i + 1][1] - chain.points[i][1], -2.0 / 7, 1e-15);
  }
  expect_clean(chain);
}

TEST(GenerateCloud, FillsTheBoxXFastest) {
  const Mesh cloud = generate(LatticeShape{{0, 0, 0}, {1, 2, 3}, {3, 2, 2}});
  const std::vector<Vec3> expected{{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0.5, 2, 0}, {1, 2, 0},
                                   {0, 0, 3}, {0.5, 0, 3}, {1, 0, 3}, {0, 2, 3}, {0.5, 2, 3}, {1, 2, 3}};
  EXPECT_EQ(cloud.points, expected);
  EXPECT_TRUE(cloud.faces.empty() && cloud.lines.empty());
}

TEST(GenerateCloud, PutsASingleParticleInTheMiddle) {
  EXPECT_EQ(generate(LatticeShape{{0, 2, 4}, {1, 3, 6}, {1, 1, 1}}).points, (std::vector<Vec3>{{0.5, 2.5, 5}}));
}

TEST(Generate, RefusesCountsBelowOneAndBeyondNumbering) {
  EXPECT_EQ(refusal([] { generate(GridShape{{1, 1}, {0, 4}}); }), "grid: cells: found 0; allowed: 1 or more");
  EXPECT_EQ(refusal([] { generate(BoxShape{{1, 1, 1}, {{4, 4, -1}}}); }), "box: cells: found -1; allowed: 1 or more");
  EXPECT_EQ(refusal([] { generate(BarShape{1, 1, 0}); }), "bar: cells: found 0; allowed: 1 or more");
  EXPECT_EQ(refusal([] { generate(ChainShape{{}, {}, 0}); }), "chain: segments: found 0; allowed: 1 or more");
  EXPECT_EQ(refusal([] { generate(LatticeShape{{}, {}, {1, 0, 1}}); }), "lattice: count: found 0; allowed: 1 or more");
  EXPECT_EQ(refusal([] { generate(SphereShape{1, -1}); }), "sphere: subdivisions: found -1; allowed: 0 or more");
  const std::string most = "; allowed: at most 134217728";
  EXPECT_EQ(refusal([] { generate(GridShape{{1, 1}, {99999, 99999}}); }), "grid: found 1e+10 points" + most);
  EXPECT_EQ(refusal([] { generate(SphereShape{1, 15}); }), "sphere: found 1.07374e+10 points" + most);
  EXPECT_EQ(refusal([] { generate(BoxShape{{1, 1, 1}, {{9999, 9999, 9999}}}); }), "box: found 6e+08 points" + most);
  EXPECT_EQ(refusal([] { generate(BarShape{1e9, 1, 1}); }), "bar: found 1e+09 points" + most);
  EXPECT_EQ(refusal([] { generate(ChainShape{{}, {}, 2147483647}); }), "chain: found 2.14748e+09 points" + most);
  EXPECT_EQ(refusal([] { generate(LatticeShape{{}, {}, {2000, 2000, 2000}}); }), "lattice: found 8e+09 points" + most);
  EXPECT_EQ(refusal([] { generate(MeshFile{"a.obj"}); }), "a.obj: found a mesh file; allowed: a generated shape");
}

using MakeMesh = MeshFiles;

TEST_F(MakeMesh, ReadsFilesAndGeneratesTheRest) {
  const std::string path = file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(make_mesh(MeshFile{path}).faces, (std::vector<Quad>{{0, 1, 2, -1}}));
  EXPECT_EQ(make_mesh(GridShape{{1, 1}, {1, 1}}).faces, (std::vector<Quad>{{0, 2, 3, 1}}));
}

TEST(ApplyTransform, ScalesThenRotatesThenTranslates) {
  Mesh mesh;
  mesh.points = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  Transform transform;
  transform.scale = {2, 3, 4};
  transform.axis = {0, 5, 0};  // only its direction counts
  transform.degrees = 90;      // x to -z, z to x
  transform.translate = {10, 20, 30};
  apply(transform, mesh);
  const std::vector<Vec3> expected{{10, 20, 28}, {10, 23, 30}, {14, 20, 30}, {10, 20, 30}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(mesh.points[i][axis], expected[i][axis], 1e-14);
  }
}

TEST(ApplyTransform, LeavesEveryBitWhereItDoesNothing) {
  Mesh mesh = generate(SphereShape{0.3, 2});
  const Mesh before = mesh;
  apply(Transform{}, mesh);
  EXPECT_EQ(mesh.points, before.points);
}

TEST(ApplyTransform, MultipliesTheVolumeByTheScales) {
  Mesh mesh = generate(SphereShape{1, 3});
  const double before = enclosed_volume(mesh);
  apply(Transform{{1, -2, 3}, {1, 1, -0.5}, 123, {0.5, 2, 3}}, mesh);
  EXPECT_NEAR(enclosed_volume(mesh), 3 * before, 1e-12);
  EXPECT_NO_THROW(require_closed(mesh, "sphere", "test"));
}

}  // namespace
}  // namespace malha
