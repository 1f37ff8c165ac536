// SPDX-License-Identifier: Apache-2.0
// Polygons: their triangulation fills them, whatever their shape, their position in space and their first corner.
#include "host/mesh/polygons.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <sstream>

#include "host/mesh/check_mesh.h"
#include "host/mesh/generate.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "tests/mesh/mesh_files.h"

namespace malha {
namespace {

using FlatPolygon = std::vector<std::array<double, 2>>;

/// The signed area, by the shoelace formula.
double shoelace_area(const FlatPolygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return twice / 2;
}

std::vector<int> corners_from(int first, std::size_t count) {
  std::vector<int> corners(count);
  for (std::size_t i = 0; i < count; ++i) corners[i] = static_cast<int>((first + i) % count);
  return corners;
}

/// A rotation of the plane z = 0 into space, and a translation.
struct Placement {
  Transform transform;
  Vec3 normal{};
  explicit Placement(std::mt19937& random) {
    std::uniform_real_distribution<double> any(-1, 1);
    transform.axis = {any(random), any(random), any(random)};
    transform.degrees = 180 * any(random);
    transform.translate = {10 * any(random), 10 * any(random), 10 * any(random)};
    Mesh up;
    up.points = {{0, 0, 0}, {0, 0, 1}};
    apply(transform, up);
    normal = minus(up.points[1], up.points[0]);
  }
  std::vector<Vec3> operator()(const FlatPolygon& polygon) const {
    Mesh mesh;
    for (const auto& [x, y] : polygon) mesh.points.push_back({x, y, 0});
    apply(transform, mesh);
    return mesh.points;
  }
};

/// Checks that a triangulation of a flat polygon is valid: n - 2 triangles of its corners that have its orientation and
/// whose areas add up to the polygon's, so that they cannot overlap. The rounding of positions 10 m away is 1e-14 of
/// the area's unit.
void expect_fills(const FlatPolygon& polygon, const Placement& place, int first) {
  const std::vector<Vec3> points = place(polygon);
  const std::vector<Triangle> triangles = triangulate(points, corners_from(first, polygon.size()));
  ASSERT_EQ(triangles.size(), polygon.size() - 2) << "first corner " << first;
  double sum = 0, smallest = 1;
  for (const auto& [a, b, c] : triangles) {
    const double along = dot(cross(minus(points[b], points[a]), minus(points[c], points[a])), place.normal) / 2;
    smallest = std::min(smallest, along), sum += along;
  }
  EXPECT_GT(smallest, 0) << "first corner " << first;
  EXPECT_NEAR(sum, shoelace_area(polygon), 1e-12) << "first corner " << first;
}

/// A polygon around the origin with corners at random distances: rarely convex.
FlatPolygon random_star(std::mt19937& random, int corners) {
  std::uniform_real_distribution<double> distance(0.1, 1);
  FlatPolygon star;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners, r = distance(random);
    star.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return star;
}

/// A comb of teeth, which is not star-shaped.
FlatPolygon comb(int teeth) {
  FlatPolygon polygon{{0, 0}, {double(teeth), 0}};
  for (int i = teeth; i > 0; --i) polygon.push_back({i - 0.4, 1}), polygon.push_back({i - 0.9, 0.1});
  return polygon;
}

/// A strip that winds twice round its start.
FlatPolygon spiral(int steps) {
  FlatPolygon polygon;
  const auto add = [&](int i, double out) {
    const double angle = 4 * std::numbers::pi * i / steps, r = 0.2 + out + angle / 12;
    polygon.push_back({r * std::cos(angle), r * std::sin(angle)});
  };
  for (int i = 0; i <= steps; ++i) add(i, 0.2);
  for (int i = steps; i >= 0; --i) add(i, 0);
  return polygon;
}

TEST(Polygons, AreFilledByTheirTrianglesFromAnyFirstCorner) {
  std::mt19937 random(7);
  std::vector<FlatPolygon> all{comb(5), spiral(24)};
  for (int corners = 5; corners < 25; ++corners)
    for (int k = 0; k < 5; ++k) all.push_back(random_star(random, corners));
  for (const FlatPolygon& polygon : all) {
    const Placement place(random);
    for (std::size_t first = 0; first < polygon.size(); ++first) expect_fills(polygon, place, static_cast<int>(first));
  }
}

TEST(Polygons, KeepCornersOnStraightSides) {
  std::mt19937 random(8);
  FlatPolygon square;  // each side has eight corners
  for (int i = 0; i < 8; ++i) square.push_back({i / 8.0, 0});
  for (int i = 0; i < 8; ++i) square.push_back({1, i / 8.0});
  for (int i = 8; i > 0; --i) square.push_back({i / 8.0, 1});
  for (int i = 8; i > 0; --i) square.push_back({0, i / 8.0});
  const FlatPolygon triangle{{0, 0}, {0.25, 0}, {0.5, 0}, {0.75, 0}, {1, 0}, {0.3, 1}};
  for (const FlatPolygon& polygon : {square, triangle}) {
    const Placement place(random);
    for (std::size_t first = 0; first < polygon.size(); ++first) expect_fills(polygon, place, static_cast<int>(first));
  }
}

TEST(Polygons, AreFilledAroundAHoleThatSidesLeadToAndFrom) {
  std::mt19937 random(9);
  const FlatPolygon framed{{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}};
  const Placement place(random);
  for (std::size_t first = 0; first < framed.size(); ++first) expect_fills(framed, place, static_cast<int>(first));
  EXPECT_DOUBLE_EQ(shoelace_area(framed), 8);
}

TEST(Polygons, ThatAreNotQuiteFlatAreFilledInTheirBestPlane) {
  std::mt19937 random(10);
  std::uniform_real_distribution<double> height(-0.02, 0.02);
  for (int k = 0; k < 40; ++k) {
    const FlatPolygon star = random_star(random, 12);
    std::vector<Vec3> points;
    for (const auto& [x, y] : star) points.push_back({x, y, height(random)});
    const std::vector<Triangle> triangles = triangulate(points, corners_from(k % 12, 12));
    ASSERT_EQ(triangles.size(), 10u);
    double sum = 0;
    for (const auto& [a, b, c] : triangles) {
      const double along_z = cross(minus(points[b], points[a]), minus(points[c], points[a]))[2] / 2;
      EXPECT_GT(along_z, -1e-3);  // the best plane leans by some hundredths
      sum += along_z;
    }
    EXPECT_NEAR(sum, shoelace_area(star), 1e-12);
  }
}

TEST(Polygons, StayFansFromTheirFirstCornerWhereThatFillsThem) {
  std::vector<Vec3> points;
  for (int i = 0; i < 7; ++i) points.push_back({std::cos(0.9 * i), 0, -std::sin(0.9 * i)});
  EXPECT_EQ(triangulate(points, corners_from(2, 7)),
            (std::vector<Triangle>{{2, 3, 4}, {2, 4, 5}, {2, 5, 6}, {2, 6, 0}, {2, 0, 1}}));
}

TEST(Polygons, WithoutAnAreaAreFans) {
  const std::vector<Vec3> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {1.5, 1.5, 1.5}};
  EXPECT_EQ(triangulate(line, corners_from(0, 5)), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(Polygons, ThatCrossThemselvesHaveNoTriangles) {
  std::vector<Vec3> pentagram;
  for (int i = 0; i < 5; ++i)
    pentagram.push_back({std::cos(4 * std::numbers::pi * i / 5), std::sin(4 * std::numbers::pi * i / 5), 0});
  EXPECT_TRUE(triangulate(pentagram, corners_from(0, 5)).empty());
  const std::vector<Vec3> eight{{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 2, 0}, {1, 1, 0}, {0, 2, 0}};  // sides touch
  EXPECT_TRUE(triangulate(eight, corners_from(0, 6)).empty());
}

class PolygonFiles : public MeshFiles {};

/// The mass of the file's mesh at 1 kg/m^2.
double weight_of(Mesh mesh) {
  check_mesh(mesh, "", false);
  const std::vector<double> mass = masses_by_density(mesh, 1);
  return std::accumulate(mass.begin(), mass.end(), 0.0);
}

TEST_F(PolygonFiles, WeighTheSameFromAnyFirstCorner) {
  const std::string hook = "0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n", arrow = "0 0 0\n2 1 0\n0 2 0\n0.5 1 0\n";
  for (const auto& [points, corners, area] : {std::tuple{hook, 6, 3.0}, {arrow, 4, 1.5}})
    for (int first = 0; first < corners; ++first) {
      std::ostringstream off, obj, ply;
      off << "OFF " << corners << " 1 0\n" << points << corners;
      ply << "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex " << corners
          << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
          << corners;
      obj << "f";  // a face may precede its vertices
      for (const int corner : corners_from(first, corners))
        off << ' ' << corner, ply << ' ' << corner, obj << ' ' << corner + 1;
      ply << '\n' << points;
      obj << "\n";
      std::istringstream lines(points);
      for (std::string line; std::getline(lines, line);) obj << "v " << line << '\n';
      EXPECT_NEAR(weight_of(read_mesh(file("a.off", off.str()))), area, 1e-12) << first;
      EXPECT_NEAR(weight_of(read_mesh(file("a.ply", ply.str()))), area, 1e-12) << first;
      Mesh mesh = read_mesh(file("a.obj", obj.str()));
      EXPECT_NEAR(weight_of(mesh), area, 1e-12) << first;
      check_mesh(mesh, "a.obj", false);
      for (const auto& [a, b, c] : triangles(mesh))
        EXPECT_GT(cross(minus(mesh.points[b], mesh.points[a]), minus(mesh.points[c], mesh.points[a]))[2], 0) << first;
    }
}

TEST_F(PolygonFiles, ThatCrossThemselvesAreRefusedByLineAndFace) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 0.5 0\n";
  const auto place = [&](const std::string& path) { return refusal([&] { read_mesh(path); }).substr(path.size()); };
  EXPECT_TRUE(place(file("a.obj", points + "f 1 2 5\nf 1 2 3 4\n")).starts_with(": line 7, face 1 (0-based): "));
  EXPECT_TRUE(place(file("b.obj", points + "\nf 1 2 3 4 5\n")).starts_with(": line 7, face 0 (0-based): "));
  EXPECT_TRUE(place(file("a.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 2 3\n"))
                  .starts_with(": line 7, face 0 (0-based): "));
  const std::string header =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  EXPECT_TRUE(place(file("a.ply", "ply\nformat ascii 1.0\n" + header + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 2 3\n"))
                  .starts_with(": line 14, face 0 (0-based): "));
  std::string binary = "ply\nformat binary_little_endian 1.0\n" + header;
  for (const float x : {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}) append(binary, x);
  append(binary, std::uint8_t{4});
  for (const int corner : {0, 1, 2, 3}) append(binary, corner);
  EXPECT_TRUE(place(file("b.ply", binary)).starts_with(": face 0 (0-based): "));
}

TEST(Polygons, QuadsThatCrossThemselvesAreRefusedWhateverTheyComeFrom) {
  Mesh mesh = generate(MeshDataShape{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2, 3}}, {}, {}});
  EXPECT_TRUE(refusal([&] { check_mesh(mesh, "mesh_data", false); }).starts_with("mesh_data: face 0 (0-based): "));
}

// A quad of a public model (the control mesh of Crane's cow): a strip of 5 mm that is turned by more than a right
// angle.
TEST(Polygons, TwistedQuadsWhoseSidesPassEachOtherInSpaceAreTaken) {
  const std::vector<Vec3> points{{0.210205, 0.758202, -0.246046},
                                 {0.169506, 0.796441, -0.370178},
                                 {0.17047, 0.793819, -0.366116},
                                 {0.211178, 0.765424, -0.239481}};
  for (int first = 0; first < 4; ++first) {
    const std::vector<int> corners = corners_from(first, 4);
    EXPECT_EQ(crossing_sides(points, corners)[0], -1) << first;
    // Each diagonal gives two triangles: half of both areas.
    double areas = 0;
    for (int k = 0; k < 4; ++k)
      areas += norm(cross(minus(points[(k + 1) % 4], points[k]), minus(points[(k + 2) % 4], points[k]))) / 4;
    EXPECT_NEAR(weight_of(generate(MeshDataShape{points, {{corners[0], corners[1], corners[2], corners[3]}}, {}, {}})),
                areas, 1e-12)
        << first;
  }
  // Projected to its plane it crosses itself, wherever it lies and however its file was rounded.
  std::vector<Vec3> flat = points;
  const Vec3 n = cross(minus(points[1], points[0]), minus(points[3], points[2]));
  const double gap = dot(minus(points[2], points[0]), n) / dot(n, n);
  for (int i = 2; i < 4; ++i)
    for (int k = 0; k < 3; ++k) flat[i][k] = std::round((flat[i][k] - gap * n[k]) * 1e6) / 1e6;
  for (int first = 0; first < 4; ++first) EXPECT_GE(crossing_sides(flat, corners_from(first, 4))[0], 0) << first;
}

}  // namespace
}  // namespace malha
