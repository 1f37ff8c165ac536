// SPDX-License-Identifier: Apache-2.0
#include "host/environment/closest_point_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "host/mesh/generate.h"
#include "tests/self_collision/brute_force.h"

namespace malha {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Mesh moved(Mesh mesh, const Point& by) {
  for (Vec3& x : mesh.points) x = {x[0] + by.x, x[1] + by.y, x[2] + by.z};
  return mesh;
}

Point at(const Vec3& x) { return {x[0], x[1], x[2]}; }

/// A closed roof of 20 degrees, 2 m long: at its ridge the angle between both faces' normals is large.
Mesh wedge() {
  Mesh mesh;
  const double half = std::tan(std::numbers::pi / 18);
  mesh.points = {{-1, 0, 0}, {1, 0, 0}, {1, -1, half}, {-1, -1, half}, {1, -1, -half}, {-1, -1, -half}};
  mesh.faces = {{0, 3, 2, 1}, {0, 1, 4, 5}, {3, 5, 4, 2}, {0, 5, 3, -1}, {1, 2, 4, -1}};
  return mesh;
}

/// Closest points and their signs against brute force, for points around the mesh.
void expect_as_brute_force(const Mesh& mesh, unsigned seed, int points) {
  const Device device;
  const ClosestPointIndex surface(device, mesh);
  const BruteForce brute(mesh);
  Random random(seed);
  int inside = 0, outside = 0;
  for (int i = 0; i < points; ++i) {
    Point p = random.in_cube(1.2 * surface.diagonal() / 2);
    if (i % 2 == 0)  // close to a corner or an edge, where the sign is difficult
      p = at(mesh.points[random.below(static_cast<int>(mesh.points.size()))]) + random.in_cube(0.05);
    const ClosestPoint found = surface.closest(p, 10);
    ASSERT_TRUE(found.found);
    const double distance = brute.distance(p);
    EXPECT_NEAR(found.distance, distance, 1e-12);
    EXPECT_NEAR(norm(p - found.q), distance, 1e-12);
    EXPECT_NEAR(brute.distance(found.q), 0, 1e-12) << "q lies on the surface";
    EXPECT_NEAR(norm(found.normal), 1, 1e-12);
    EXPECT_FALSE(found.boundary) << "a closed mesh has no rim";
    const bool is_inside = brute.winding(p) > 0.5;
    EXPECT_EQ(dot(found.normal, p - found.q) < 0, is_inside) << p.x << ", " << p.y << ", " << p.z;
    ++(is_inside ? inside : outside);
  }
  EXPECT_GT(inside, points / 50);
  EXPECT_GT(outside, points / 10);
}

TEST(ClosestPointIndex, ClosestPointAndSideAreThoseOfBruteForceOnASphere) {
  expect_as_brute_force(generate(SphereShape{1, 2}), 1, 2000);
}

TEST(ClosestPointIndex, ClosestPointAndSideAreThoseOfBruteForceOnABox) {
  expect_as_brute_force(generate(BoxShape{{1, 0.3, 2}, {{2, 1, 3}}}), 2, 2000);
}

TEST(ClosestPointIndex, ClosestPointAndSideAreThoseOfBruteForceOnASharpWedge) {
  expect_as_brute_force(wedge(), 3, 3000);
}

TEST(ClosestPointIndex, TellsTheSideByThePseudonormalWhereAFaceNormalWouldNot) {
  const Device device;
  const ClosestPointIndex surface(device, wedge());
  // Beyond the ridge the point is nearer to the plane of one face: it is outside, though behind the other face.
  const Point p{0.1, 0.02, 0.1};
  const ClosestPoint found = surface.closest(p, 1);
  ASSERT_TRUE(found.found);
  EXPECT_NEAR(norm(found.q - Point{0.1, 0, 0}), 0, 1e-15);
  EXPECT_GT(dot(found.normal, p - found.q), 0);
  const double a = std::numbers::pi / 18;
  const Point faces[2] = {{0, std::sin(a), std::cos(a)}, {0, std::sin(a), -std::cos(a)}};
  EXPECT_LT(dot(faces[1], p - found.q), 0) << "the example is one in which a face normal fails";
  EXPECT_NEAR(norm(found.normal - Point{0, 1, 0}), 0, 1e-12);
}

TEST(ClosestPointIndex, PseudonormalsOfCornersDoNotDependOnHowTheyAreCutIntoTriangles) {
  // A box corner has three right angles, however its quads are split: the normal is the diagonal.
  const Device device;
  const ClosestPointIndex surface(device, generate(BoxShape{{2, 2, 2}, {{1, 1, 1}}}));
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) {
        const ClosestPoint found = surface.closest({1.1 * x, 1.1 * y, 1.1 * z}, 1);
        EXPECT_NEAR(norm(found.normal - Point{x, y, z} * (1 / std::sqrt(3.0))), 0, 1e-12);
      }
}

TEST(ClosestPointIndex, FindsNothingBeyondTheRadius) {
  const Device device;
  const ClosestPointIndex surface(device, generate(BoxShape{{2, 2, 2}, {{2, 2, 2}}}));
  EXPECT_FALSE(surface.closest({0, 1.5, 0}, 0.4999).found);
  EXPECT_TRUE(surface.closest({0, 1.5, 0}, 0.5001).found);
  EXPECT_FALSE(surface.closest({0, 1.5, 0}, 0).found);
  // The radius is exact to the last digits of double, though Embree's query is in float.
  const BruteForce brute(generate(BoxShape{{2, 2, 2}, {{2, 2, 2}}}));
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    const Point p = random.in_cube(i % 2 == 0 ? 2 : 100);
    const double distance = brute.distance(p);
    EXPECT_TRUE(surface.closest(p, distance * (1 + 1e-12)).found);
    EXPECT_FALSE(surface.closest(p, distance * (1 - 1e-12)).found);
  }
}

TEST(ClosestPointIndex, FindsTheBoundaryOfAnOpenMesh) {
  const Device device;
  const ClosestPointIndex surface(device, generate(GridShape{{1, 1}, {4, 4}}));
  for (const double side : {-1.0, 1.0}) {
    EXPECT_FALSE(surface.closest({0.5, 0.1 * side, 0.5}, 1).boundary) << "a vertex inside";
    EXPECT_FALSE(surface.closest({0.6, 0.1 * side, 0.5}, 1).boundary) << "an edge inside";
    EXPECT_FALSE(surface.closest({0.6, 0.1 * side, 0.55}, 1).boundary) << "a face";
    EXPECT_FALSE(surface.closest({0.95, 0.1 * side, 0.9}, 1).boundary) << "a face at the rim";
    EXPECT_TRUE(surface.closest({1.1, 0.1 * side, 0.55}, 1).boundary) << "an edge of the rim";
    EXPECT_TRUE(surface.closest({1.1, 0.1 * side, 0.5}, 1).boundary) << "a vertex of the rim";
    EXPECT_TRUE(surface.closest({-0.1, 0.1 * side, -0.1}, 1).boundary) << "a corner";
    // Beyond the boundary, in front of the plane counts as in front, and behind it as behind.
    const Point p{1.1, 0.1 * side, 0.5};
    const ClosestPoint found = surface.closest(p, 1);
    EXPECT_EQ(dot(found.normal, p - found.q) > 0, side > 0);
  }
}

TEST(ClosestPointIndex, AKnownTriangleChangesNothing) {
  const Device device;
  const Mesh mesh = generate(SphereShape{1, 3});
  const ClosestPointIndex surface(device, mesh);
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Point p = i % 4 == 0 ? at(mesh.points[i % 642]) * random(0.5, 1.5) : random.in_cube(1.5);
    const double radius = random(0, 1);
    const ClosestPoint found = surface.closest(p, radius);
    const ClosestPoint again = surface.closest(p, radius, random.below(20 << 6));
    ASSERT_EQ(again.found, found.found);
    if (!found.found) continue;
    ASSERT_EQ(again.triangle, found.triangle);
    ASSERT_TRUE(same_bits(again.q, found.q) && same_bits(again.normal, found.normal));
  }
}

TEST(ClosestPointIndex, CrossingIsTheFirstOfBruteForce) {
  const Device device;
  for (const Mesh& mesh : {generate(SphereShape{1, 3}), wedge(), generate(BoxShape{{1, 1, 1}, {{3, 3, 3}}})}) {
    const ClosestPointIndex surface(device, mesh);
    const BruteForce brute(mesh);
    Random random(5);
    int hits = 0;
    for (int i = 0; i < 1000; ++i) {
      const Point a = random.in_cube(1.5), b = random.in_cube(1.5);
      // Within the tolerance of a triangle the two may differ on purpose.
      if (brute.distance(a) < 1e-4 || brute.distance(b) < 1e-4) continue;
      for (const bool front_only : {false, true}) {
        const double t = brute.crossing(a, b, front_only);
        const Crossing found = surface.crossing(a, b, 0, front_only);
        ASSERT_EQ(found.hit, t <= 1) << a.x << ", " << a.y << ", " << a.z << " to " << b.x << ", " << b.y << ", "
                                     << b.z;
        if (!found.hit) continue;
        ++hits;
        EXPECT_LT(norm(found.q - (a + (b - a) * t)), 1e-5)
            << "near the edges another triangle may be hit first, in float";
        EXPECT_NEAR(norm(found.normal), 1, 1e-12);
        EXPECT_TRUE(!front_only || dot(found.normal, b - a) < 0);
      }
    }
    EXPECT_GT(hits, 100);
  }
}

TEST(ClosestPointIndex, CrossingLiesOnTheSphereWhereTheLineEntersIt) {
  const Device device;
  const Mesh mesh = generate(SphereShape{1, 5});
  const ClosestPointIndex surface(device, mesh);
  double longest = 0;
  for (const Edge& e : edges(mesh)) longest = std::max(longest, norm(at(mesh.points[e[0]]) - at(mesh.points[e[1]])));
  Random random(6);
  for (int i = 0; i < 500; ++i) {
    const Point from = random.direction() * 2.0, through = random.in_cube(0.3);
    const Point d = (through - from) * (1 / norm(through - from));
    const double along = dot(from, d), t = -along - std::sqrt(along * along - dot(from, from) + 1);
    const Crossing found = surface.crossing(from, from + d * 4.0, 0, true);
    ASSERT_TRUE(found.hit);
    // Facets lie up to edge^2 / 6 inside; a slanted line meets them later by that over its cosine.
    EXPECT_LT(norm(found.q - (from + d * t)), longest * longest / 6 / std::abs(dot(found.normal, d)) + 1e-6);
    EXPECT_GT(dot(found.normal, found.q), 0.99);
  }
}

TEST(ClosestPointIndex, CrossingKeepsToTheSegmentAndWhatLiesBeyond) {
  const Device device;
  const ClosestPointIndex surface(device, generate(GridShape{{1, 1}, {3, 3}}));
  const Point above{0.4, 0.5, 0.4};
  EXPECT_FALSE(surface.crossing(above, {0.4, 0.01, 0.4}, 0, true).hit);
  EXPECT_TRUE(surface.crossing(above, {0.4, 0.01, 0.4}, 0.011, true).hit);
  EXPECT_TRUE(surface.crossing(above, {0.4, -0.01, 0.4}, 0, true).hit);
  EXPECT_FALSE(surface.crossing(above, above, 1, true).hit) << "no way, no crossing";
}

TEST(ClosestPointIndex, FrontOnlyPassesBacksAndGoesOnToTheNextFront) {
  const Device device;
  const ClosestPointIndex sheet(device, generate(GridShape{{1, 1}, {3, 3}}));
  EXPECT_FALSE(sheet.crossing({0.4, -0.5, 0.4}, {0.4, 0.5, 0.4}, 0, true).hit);
  EXPECT_TRUE(sheet.crossing({0.4, -0.5, 0.4}, {0.4, 0.5, 0.4}, 0, false).hit);
  // From one box into the next: the back of the first does not hide the front of the second.
  Mesh two = generate(BoxShape{{1, 1, 1}, {{1, 1, 1}}});
  const Mesh other = moved(two, {3, 0, 0});
  const int first = static_cast<int>(two.points.size());
  two.points.insert(two.points.end(), other.points.begin(), other.points.end());
  for (Quad face : other.faces) {
    for (int& corner : face) corner += first;
    two.faces.push_back(face);
  }
  const Crossing found = ClosestPointIndex(device, two).crossing({0.1, 0.1, 0.1}, {3.1, 0.1, 0.1}, 0, true);
  ASSERT_TRUE(found.hit);
  EXPECT_NEAR(found.q.x, 2.5, 1e-6);
}

TEST(ClosestPointIndex, StartingOnTheSurfaceCrossesGoingInAndNotGoingOut) {
  const Device device;
  const Mesh mesh = generate(SphereShape{1, 3});
  const ClosestPointIndex surface(device, mesh);
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const Point towards = i < 642 ? at(mesh.points[i]) : random.direction();
    const ClosestPoint on = surface.closest(towards, 1);
    // The line enters at every angle up to 60 degrees; a start on the surface is up to a rounding of float before or
    // behind it.
    const Point in = -on.normal + random.in_cube(0.5), start = on.q + on.normal * (1e-7 * random());
    const Crossing found = surface.crossing(start, start + in * 0.1, 0, true);
    ASSERT_TRUE(found.hit) << i;
    EXPECT_LT(norm(found.q - start), 1e-4);
    EXPECT_FALSE(surface.crossing(start, start - in * 0.1, 0, true).hit) << i;
  }
}

TEST(ClosestPointIndex, WhatMovesAwayFromATwoSidedSurfaceDoesNotCrossItHoweverNearItStarts) {
  const Device device;
  const ClosestPointIndex surface(device,
                                  generate(GridShape{{1000, 1000}, {10, 10}}));  // the surface's tolerance is 7 mm
  for (const double side : {-1.0, 1.0})
    for (const double gap : {1e-6, 1e-4, 5e-3, 6e-3, 8e-3}) {
      const Point start{421, gap * side, 333};
      EXPECT_FALSE(surface.crossing(start, start + Point{0, side, 0}, 0, false).hit) << gap;
      EXPECT_TRUE(surface.crossing(start, start - Point{0, side, 0}, 0, false).hit) << gap;
    }
}

TEST(ClosestPointIndex, HasNoGapsAtVerticesAndEdgesHoweverLongTheWay) {
  const Device device;
  Mesh waves = generate(GridShape{{1, 1}, {40, 40}});
  for (Vec3& x : waves.points) x[1] = 0.05 * std::sin(7 * x[0]) * std::cos(5 * x[2]);
  const ClosestPointIndex wavy(device, waves);
  Random random(10);
  for (const Vec3& x : waves.points) {
    const bool at_the_rim = x[0] == 0 || x[0] == 1 || x[2] == 0 || x[2] == 1;
    for (int i = 0; i < (at_the_rim ? 0 : 20); ++i) {
      const Point on = at(x), in = Point{0, -1, 0} + random.in_cube(0.5);
      const Point a = on - in * random(0.5, 2), b = on + in * random(0.5, 2);
      ASSERT_TRUE(wavy.crossing(a, b, 0, true).hit) << x[0] << ", " << x[1] << ", " << x[2];
    }
  }
  const Mesh mesh = generate(SphereShape{1, 3});
  const ClosestPointIndex surface(device, mesh);
  const auto expect_hit = [&](const Point& on) {
    for (const double length : {0.01, 0.1, 1.0, 10.0, 100.0, 1000.0}) {
      Point in = -on + random.in_cube(0.5);
      if (random.below(2) == 0) in = -on;
      const Point a = on - in * (random(0.5, 1) * length), b = on + in * (random(0.5, 1) * length);
      const Crossing found = surface.crossing(a, b, 0, true);
      ASSERT_TRUE(found.hit) << on.x << ", " << on.y << ", " << on.z << ", " << length;
      EXPECT_LT(norm(found.q - on), 1e-4);
      EXPECT_TRUE(surface.crossing(a, b, 0, false).hit);
    }
  };
  for (const Vec3& x : mesh.points) expect_hit(at(x));
  for (const Edge& e : edges(mesh)) expect_hit((at(mesh.points[e[0]]) + at(mesh.points[e[1]])) * 0.5);
}

TEST(ClosestPointIndex, IsAsGoodFarFromTheOrigin) {
  const Device device;
  const Mesh mesh = generate(SphereShape{1, 3});
  const Point far{1e5, -1e5, 1e5};
  const ClosestPointIndex here(device, mesh), there(device, moved(mesh, far));
  Random random(8);
  for (int i = 0; i < 500; ++i) {
    const Point a = random.in_cube(2), b = random.in_cube(2);
    const ClosestPoint near_here = here.closest(a, 5), near_there = there.closest(a + far, 5);
    // Points at 1e5 m are rounded by 1.5e-11 m before the surface sees them.
    EXPECT_NEAR(near_here.distance, near_there.distance, 1e-10);
    EXPECT_LT(norm(near_here.q + far - near_there.q), 1e-9);
    const Crossing hit_here = here.crossing(a, b, 0, true), hit_there = there.crossing(a + far, b + far, 0, true);
    ASSERT_EQ(hit_here.hit, hit_there.hit);
    EXPECT_LT(norm(hit_here.hit ? hit_here.q + far - hit_there.q : Point{}), 1e-5);
  }
}

TEST(ClosestPointIndex, BoxDistanceIsALowerBoundAndZeroInside) {
  const Device device;
  const Mesh mesh = moved(generate(SphereShape{1, 2}), {2, 0, 0});
  const ClosestPointIndex surface(device, mesh);
  EXPECT_NEAR(surface.diagonal(), 2 * std::sqrt(3.0), 0.1);
  EXPECT_EQ(surface.box_distance({2, 0, 0}), 0);
  EXPECT_NEAR(surface.box_distance({5, 0, 0}), 2, 0.06);
  EXPECT_NEAR(surface.box_distance({6, 4, 0}), std::hypot(3, 3), 0.1);
  Random random(9);
  for (int i = 0; i < 500; ++i) {
    const Point p = random.in_cube(5);
    EXPECT_LE(surface.box_distance(p), surface.closest(p, 50).distance + 1e-12);
  }
}

TEST(ClosestPointIndex, AnswersNothingForWhatIsNotFinite) {
  const Device device;
  const ClosestPointIndex surface(device, generate(SphereShape{1, 2}));
  const Point good{0.1, 0.2, 0.3};
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinite, -kInfinite, 1e30, -1e300}) {
    for (int axis = 0; axis < 3; ++axis) {
      Point p = good;
      (axis == 0 ? p.x : axis == 1 ? p.y : p.z) = bad;
      EXPECT_FALSE(surface.closest(p, 1).found);
      EXPECT_FALSE(surface.closest(p, kInfinite).found);
      EXPECT_FALSE(surface.crossing(p, good, 0, true).hit);
      EXPECT_FALSE(surface.crossing(p, p, 0, false).hit);
      EXPECT_FALSE(!std::isfinite(bad) && surface.crossing(good, p, 0, false).hit);
    }
    EXPECT_FALSE(surface.closest({5, 5, 5}, std::isnan(bad) ? bad : -1).found);
  }
}

}  // namespace
}  // namespace malha
