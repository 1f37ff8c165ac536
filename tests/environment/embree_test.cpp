// SPDX-License-Identifier: Apache-2.0
#include "host/environment/embree.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

namespace malha {
namespace {

using P = std::array<float, 3>;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// The unit right triangle in the plane z = `height`, counter-clockwise seen from above.
struct OneTriangle {
  Device device;
  TriangleScene scene;
  explicit OneTriangle(float height = 0)
      : scene(device, std::vector<P>{{0, 0, height}, {1, 0, height}, {0, 1, height}},
              std::vector<std::array<int, 3>>{{0, 1, 2}}) {}
};

TEST(Embree, IntersectGivesDistanceBarycentricsAndRightHandedNormal) {
  const OneTriangle one(0.5f);
  const Hit hit = intersect(one.scene, {0.25f, 0.5f, 2}, {0, 0, -2}, 0, 10);
  ASSERT_TRUE(hit.hit);
  EXPECT_NEAR(hit.t, 0.75f, 1e-6f);
  EXPECT_EQ(hit.triangle, 0);
  EXPECT_EQ(hit.geometry, 0);
  EXPECT_NEAR(hit.u, 0.25f, 1e-6f);
  EXPECT_NEAR(hit.v, 0.5f, 1e-6f);
  EXPECT_NEAR(hit.normal[0], 0, 1e-6f);
  EXPECT_NEAR(hit.normal[1], 0, 1e-6f);
  EXPECT_NEAR(hit.normal[2], 1, 1e-6f);  // (p1 - p0) x (p2 - p0), whichever side the ray comes from
  EXPECT_NEAR(intersect(one.scene, {0.25f, 0.5f, -2}, {0, 0, 1}, 0, 10).normal[2], 1, 1e-6f);
}

TEST(Embree, IntersectKeepsWithinItsSegment) {
  const OneTriangle one;
  EXPECT_FALSE(intersect(one.scene, {0.2f, 0.2f, 1}, {0, 0, -1}, 0, 0.99f).hit);
  EXPECT_FALSE(intersect(one.scene, {0.2f, 0.2f, 1}, {0, 0, -1}, 1.01f, 2).hit);
  EXPECT_TRUE(intersect(one.scene, {0.2f, 0.2f, 1}, {0, 0, -1}, 0, 1.01f).hit);
  EXPECT_TRUE(intersect(one.scene, {0.2f, 0.2f, 1}, {0, 0, -1}, 0, kInf).hit);
  EXPECT_FALSE(occluded(one.scene, {0.2f, 0.2f, 1}, {0, 0, -1}, 0, 0.99f));
  EXPECT_TRUE(occluded(one.scene, {0.2f, 0.2f, 1}, {0, 0, -1}, 0, 1.01f));
}

TEST(Embree, RaysThatEmbreeWouldAbortOnHitNothing) {
  const OneTriangle one;
  const P o{0.2f, 0.2f, 1}, d{0, 0, -1};
  for (const float bad : {kNan, kInf, -kInf, 1e30f}) {
    for (int axis = 0; axis < 3; ++axis) {
      P x = o, y = d;
      x[axis] = bad;
      y[axis] = bad;
      EXPECT_FALSE(intersect(one.scene, x, d, 0, 10).hit);
      EXPECT_FALSE(intersect(one.scene, o, y, 0, 10).hit);
      EXPECT_FALSE(occluded(one.scene, x, d, 0, 10));
      EXPECT_FALSE(occluded(one.scene, o, y, 0, 10));
      point_query(one.scene, x, 1, [](int) -> float { throw std::logic_error("a bad point was searched"); });
    }
  }
  EXPECT_FALSE(intersect(one.scene, o, {0, 0, 0}, 0, 10).hit);
  EXPECT_FALSE(intersect(one.scene, o, d, -1, 10).hit);
  EXPECT_FALSE(intersect(one.scene, o, d, 2, 1).hit);
  EXPECT_FALSE(intersect(one.scene, o, d, kNan, 10).hit);
  EXPECT_FALSE(intersect(one.scene, o, d, 0, kNan).hit);
  for (const float radius : {kNan, kInf, -1.0f}) {
    point_query(one.scene, o, radius, [](int) -> float { throw std::logic_error("a bad radius was searched"); });
  }
}

TEST(Embree, PointQueryFindsTheTrianglesWithinTheRadiusAndShrinks) {
  // A row of triangles along x, each within [i, i + 0.5].
  std::vector<P> points;
  std::vector<std::array<int, 3>> triangles;
  constexpr int kCount = 200;
  for (int i = 0; i < kCount; ++i) {
    const auto x = static_cast<float>(i);
    points.insert(points.end(), {{x, 0, 0}, {x + 0.5f, 0, 0}, {x, 0.5f, 0}});
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Device device;
  const TriangleScene scene(device, points, triangles);
  std::vector<int> seen(kCount, 0);
  const float radius = 10.25f;
  point_query(scene, {100, 0, 0}, radius, [&](int i) {
    ++seen[static_cast<std::size_t>(i)];
    return radius;
  });
  for (int i = 0; i < kCount; ++i) {
    const bool within = i <= 110 && i + 0.5f >= 100 - radius;
    if (within) {
      EXPECT_EQ(seen[static_cast<std::size_t>(i)], 1) << i;  // visited once, none missed
    }
  }
  int visits = 0, nearest = -1;
  float best = 1000;
  point_query(scene, {100.1f, 0, 0}, best, [&](int i) {
    ++visits;
    const float x = static_cast<float>(i);
    const float distance = 100.1f < x ? x - 100.1f : (100.1f > x + 0.5f ? 100.1f - x - 0.5f : 0);
    if (distance < best) best = distance, nearest = i;
    return best;
  });
  EXPECT_EQ(nearest, 100);
  EXPECT_LT(visits, kCount / 2);  // a radius that does not shrink would visit all
}

TEST(Embree, EmptyAndNonFiniteTrianglesAreNeverHit) {
  const Device device;
  const TriangleScene empty(device, {}, {});
  EXPECT_FALSE(intersect(empty, {0, 0, 1}, {0, 0, -1}, 0, 10).hit);
  const std::vector<P> points{{0, 0, 0}, {1, 0, 0}, {0, kNan, 0}, {0, 1, 0}, {0, kInf, 0}, {0, 0, 0}};
  const std::vector<std::array<int, 3>> triangles{{0, 1, 2}, {0, 1, 4}, {0, 5, 1}, {0, 1, 3}};
  const TriangleScene scene(device, points, triangles);
  const Hit hit = intersect(scene, {0.2f, 0.2f, 1}, {0, 0, -1}, 0, 10);
  ASSERT_TRUE(hit.hit);
  EXPECT_EQ(hit.triangle, 3);  // all other triangles are degenerate
}

TEST(Embree, SpheresAndCapsulesAreHitWhereTheirFormulasSay) {
  const Device device;
  RayScene scene(device);
  const int spheres = scene.add_spheres(std::vector<std::array<float, 4>>{{5, 0, 0, 0.5f}});
  const int capsules = scene.add_capsules(
      std::vector<std::array<float, 4>>{{-1, 0, 0, 0.25f}, {1, 0, 0, 0.25f}, {-1, 9, 0, 0.5f}, {1, 9, 0, 0.5f}});
  scene.commit();
  const float tolerance = 1e-4f;  // Embree's curves use approximate reciprocals
  const Hit sphere = intersect(scene, {5, 0, 3}, {0, 0, -1}, 0, 10);
  EXPECT_EQ(sphere.geometry, spheres);
  EXPECT_NEAR(sphere.t, 2.5f, tolerance);
  const Hit side = intersect(scene, {0.3f, 0, 3}, {0, 0, -1}, 0, 10);
  EXPECT_EQ(side.geometry, capsules);
  EXPECT_NEAR(side.t, 2.75f, tolerance);
  // Towards the middle of the end's half sphere, at 45 degrees: 3 sqrt(2) away, less the radius.
  const Hit cap = intersect(scene, {4, 12, 0}, {-1, -1, 0}, 0, 10);
  EXPECT_EQ(cap.geometry, capsules);
  EXPECT_EQ(cap.triangle, 1);
  EXPECT_NEAR(cap.t * std::sqrt(2.0f), 3 * std::sqrt(2.0f) - 0.5f, tolerance);
}

TEST(Embree, TooLittleMemoryIsThatOfAnyoneElse) {
  embree_detail::ErrorLog log;
  embree_detail::log_error(&log, RTC_ERROR_OUT_OF_MEMORY, "out of memory");
  EXPECT_THROW(embree_detail::throw_error(log.code, log.message), std::bad_alloc);
}

// Queries, changes and errors need the device, and so does the end of the scene.
TEST(Embree, ASceneKeepsItsDevice) {
  auto device = std::make_unique<Device>();
  TriangleScene scene(*device, std::vector<P>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                      std::vector<std::array<int, 3>>{{0, 1, 2}});
  device.reset();
  EXPECT_TRUE(intersect(scene, {0.25f, 0.25f, 1}, {0, 0, -1}, 0, 2).hit);
  EXPECT_EQ(scene.add_spheres(std::vector<std::array<float, 4>>{{5, 5, 0, 1}}), 1);
  scene.commit();
  EXPECT_TRUE(intersect(scene, {5, 5, 3}, {0, 0, -1}, 0, 3).hit);
}

TEST(Embree, ErrorsBecomeExceptions) {
  const Device device;
  rtcSetSceneFlags(nullptr, RTC_SCENE_FLAG_ROBUST);  // an error without a device: it must not reach ours
  EXPECT_NO_THROW(device.check());
  RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_UINT, 4, 3);  // not a vertex format
  rtcReleaseGeometry(geometry);
  EXPECT_THROW(device.check(), std::runtime_error);
  EXPECT_NO_THROW(device.check());  // an error is reported once
}

}  // namespace
}  // namespace malha
