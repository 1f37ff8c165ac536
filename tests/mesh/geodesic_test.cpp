// SPDX-License-Identifier: Apache-2.0
// Distances along meshes, against straight lines on flat ones and great circles on spheres.
#include "host/mesh/geodesic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/mesh/generate.h"
#include "tests/constraints/mixed_sheet.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// The largest relative error of distances from straight lines.
double worst(const Mesh& mesh, int source) {
  const Geodesics found = geodesics(mesh, {source});
  double error = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const double straight = length(mesh.points[i] - mesh.points[source]);
    if (straight > 0) error = std::max(error, std::abs(found.distance[i] - straight) / straight);
  }
  return error;
}

TEST(Geodesics, AreStraightOnAGridFromAnyPoint) {
  for (const std::array<double, 2>& size : {std::array{3.0, 2.0}, std::array{3.0, 6.0}}) {
    const Mesh grid = make_mesh(GridShape{size, {30, 20}});
    for (const int source : {0, 30, 325})
      EXPECT_LT(worst(grid, source), 1e-9);  // the sums' rounding; edges alone: 0.41
  }
}

/// The largest relative error of distances on a flat convex mesh, compared with the straight line to the nearest
/// source.
double worst_of_many(const Mesh& mesh, const std::vector<int>& sources) {
  const Geodesics found = geodesics(mesh, sources);
  double error = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    double straight = INFINITY;
    for (const int s : sources) straight = std::min(straight, length(mesh.points[i] - mesh.points[s]));
    if (straight > 0) error = std::max(error, std::abs(found.distance[i] / straight - 1));
    EXPECT_NEAR(length(mesh.points[i] - mesh.points[found.source[i]]), straight, 1e-8) << "the source is the nearest";
  }
  return error;
}

TEST(Geodesics, AreStraightFromRowsAndPointsOfIrregularFlatMeshes) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const bool graded : {false, true}) {
      const int cells = 24;
      const Mesh mesh = mixed_sheet(cells, graded, seed);
      std::vector<int> row, scattered{0, cells * (cells + 1) + 5, 2 * cells * (cells + 1) + 17};
      for (int i = 0; i <= cells; ++i) row.push_back(i);
      EXPECT_LT(worst_of_many(mesh, row), 2e-9) << seed;  // the bound that counts as rounding; edges alone: 0.3
      EXPECT_LT(worst_of_many(mesh, scattered), 2e-9) << seed;
      EXPECT_LT(worst_of_many(mesh, {cells * (cells + 1) + 5}), 2e-9) << seed;
    }
}

/// The path leads from a corner of a cube straight across the faces that meet there, and to the three others round the
/// nearest edge.
TEST(Geodesics, GoRoundTheEdgesOfACube) {
  const Mesh cube = make_mesh(BoxShape{{1, 1, 1}, {{6, 7, 5}}});
  Vec3 low = cube.points[0];
  for (const Vec3& p : cube.points)
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]);
  int corner = 0;
  for (std::size_t i = 0; i < cube.points.size(); ++i)
    if (length(cube.points[i] - low) < 1e-12) corner = static_cast<int>(i);
  const Geodesics found = geodesics(cube, {corner});
  for (std::size_t i = 0; i < cube.points.size(); ++i) {
    const Vec3 p = cube.points[i] - low;
    double way = INFINITY;
    for (int k = 0; k < 3; ++k) {
      const double u = p[(k + 1) % 3], v = p[(k + 2) % 3];
      if (p[k] < 1e-12) way = std::min(way, std::hypot(u, v));
      if (p[k] > 1 - 1e-12) way = std::min({way, std::hypot(1 + u, v), std::hypot(u, 1 + v)});
    }
    EXPECT_NEAR(found.distance[i], way, 1e-8) << i;
  }
}

TEST(Geodesics, FollowGreatCirclesOnASphere) {
  for (const int subdivisions : {2, 3, 4}) {
    const Mesh sphere = make_mesh(SphereShape{1, subdivisions});
    const Geodesics found = geodesics(sphere, {0});
    double most = 0, least = 0;
    for (std::size_t i = 1; i < sphere.points.size(); ++i) {
      const Vec3 &a = sphere.points[0], &b = sphere.points[i];
      const double arc = std::acos(std::clamp(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], -1.0, 1.0));
      most = std::max(most, found.distance[i] / arc - 1), least = std::min(least, found.distance[i] / arc - 1);
    }
    // Faces with edges of e <= 1.11 / 2^n rad lie at most e^2 / 6 of the radius below the sphere.
    EXPECT_LE(most, 1e-9) << subdivisions;
    EXPECT_GT(least, -1.11 * 1.11 / 6 / std::pow(4, subdivisions)) << subdivisions;
  }
}

/// The path bends round a concave corner: a square of 2 m without its quarter x > 1, z > 1.
TEST(Geodesics, GoRoundACorner) {
  Mesh mesh = make_mesh(GridShape{{2, 2}, {40, 40}});
  std::vector<Quad> left;
  for (const Quad& q : mesh.faces) {
    const Vec3 &a = mesh.points[q[0]], &b = mesh.points[q[2]];
    if (a[0] + b[0] < 2 || a[2] + b[2] < 2) left.push_back(q);
  }
  mesh.faces = left;
  const int source = 40;  // x = 2, z = 0
  const Geodesics found = geodesics(mesh, {source});
  double most = 0, least = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    if (!std::isfinite(found.distance[i]) || int(i) == source) continue;
    const Vec3 corner{1, 0, 1};
    const bool hidden = p[0] < 1 + 1e-9 && p[2] > 1 && p[2] > 2 - p[0];
    const double d =
        hidden ? length(p - corner) + length(mesh.points[source] - corner) : length(p - mesh.points[source]);
    most = std::max(most, found.distance[i] / d - 1), least = std::min(least, found.distance[i] / d - 1);
  }
  EXPECT_GT(least, -1e-9);
  EXPECT_LT(most, 1e-9) << "behind the corner too";
}

TEST(Geodesics, NameTheNearestSource) {
  const Mesh chain = make_mesh(ChainShape{{0, 0, 0}, {10, 0, 0}, 10});
  const Geodesics found = geodesics(chain, {0, 10});
  EXPECT_EQ(found.source, (std::vector<int>{0, 0, 0, 0, 0, found.source[5], 10, 10, 10, 10, 10}));
  for (int i = 0; i <= 10; ++i) EXPECT_NEAR(found.distance[i], std::min(i, 10 - i), 1e-12);
}

TEST(Geodesics, DoNotReachWhatIsNotConnected) {
  const Mesh cloud = make_mesh(LatticeShape{{0, 0, 0}, {1, 1, 1}, {2, 1, 1}});
  const Geodesics found = geodesics(cloud, {0});
  EXPECT_EQ(found.source, (std::vector<int>{0, -1}));
  EXPECT_EQ(found.distance[1], INFINITY);
}

}  // namespace
}  // namespace malha
