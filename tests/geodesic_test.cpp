// Distances along meshes, against straight lines on flat ones and great circles on spheres.
#include "host/mesh/geodesic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/mesh/generate.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// The largest |distance - straight| / straight.
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

TEST(Geodesics, AreStraightAcrossFlatTrianglesOfAnyForm) {
  Mesh mesh = make_mesh(GridShape{{1, 1}, {20, 20}});
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    Vec3& p = mesh.points[i];
    p = {p[0] + 0.6 * p[2] + 0.01 * std::sin(50.0 * double(i)), 0, p[2] + 0.01 * std::cos(70.0 * double(i))};
  }
  std::vector<Quad> triangles;
  for (const Quad& q : mesh.faces)
    triangles.push_back({q[0], q[1], q[2], -1}), triangles.push_back({q[0], q[2], q[3], -1});
  mesh.faces = triangles;
  for (const int source : {0, 220, 440}) EXPECT_LT(worst(mesh, source), 0.01) << source;  // 0.7 % from a corner
}

TEST(Geodesics, FollowGreatCirclesOnASphere) {
  for (const int subdivisions : {2, 3, 4, 5}) {
    const Mesh sphere = make_mesh(SphereShape{1, subdivisions});
    const Geodesics found = geodesics(sphere, {0});
    double most = 0, least = 0;
    for (std::size_t i = 1; i < sphere.points.size(); ++i) {
      const Vec3 &a = sphere.points[0], &b = sphere.points[i];
      const double arc = std::acos(std::clamp(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], -1.0, 1.0));
      most = std::max(most, found.distance[i] / arc - 1), least = std::min(least, found.distance[i] / arc - 1);
    }
    // Shorter at most by what straight lines save; 4.2, 2.3, 1.3 and 0.7 % when it was measured.
    EXPECT_LE(most, 1e-9) << subdivisions;
    EXPECT_GT(least, -0.3 / (1 << subdivisions)) << subdivisions;
  }
}

/// Round a concave corner: a square of 2 m without its quarter x > 1, z > 1.
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
  EXPECT_LT(most, 0.006) << "too long behind the corner";
}

TEST(Geodesics, NameTheNearestSource) {
  const Mesh chain = make_mesh(ChainShape{{0, 0, 0}, {10, 0, 0}, 10});
  const Geodesics found = geodesics(chain, {0, 10});
  EXPECT_EQ(found.source, (std::vector<int>{0, 0, 0, 0, 0, found.source[5], 10, 10, 10, 10, 10}));
  for (int i = 0; i <= 10; ++i) EXPECT_NEAR(found.distance[i], std::min(i, 10 - i), 1e-12);
}

TEST(Geodesics, DoNotReachWhatIsNotConnected) {
  const Mesh cloud = make_mesh(CloudShape{{0, 0, 0}, {1, 1, 1}, {2, 1, 1}});
  const Geodesics found = geodesics(cloud, {0});
  EXPECT_EQ(found.source, (std::vector<int>{0, -1}));
  EXPECT_EQ(found.distance[1], INFINITY);
}

}  // namespace
}  // namespace malha
