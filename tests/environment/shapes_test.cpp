// SPDX-License-Identifier: Apache-2.0
// Exact shapes: signed distances, the first point of a path at a distance, and bounds for boxes of particles.
#include "kernels/environment/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "host/model/exact_shape.h"

namespace malha {
namespace {

using ShapePoint = Vector3<double>;

const ConvexShape kAHalfSpace{}, kASphere{ConvexKind::RoundedBox, {0, 0, 0}, 0.7},
    kACapsule{ConvexKind::RoundedBox, {0, 0.6, 0}, 0.3}, kABox{ConvexKind::RoundedBox, {0.4, 0.7, 0.2}, 0},
    kACylinder{ConvexKind::Cylinder, {0, 0.6, 0}, 0.4};
const ConvexShape kAllShapes[]{kAHalfSpace, kASphere, kACapsule, kABox, kACylinder};

class ShapePoints {
 public:
  ShapePoint next(double most = 1.5) {
    std::uniform_real_distribution<double> any(-most, most);
    return {any(random_), any(random_), any(random_)};
  }

 private:
  std::mt19937 random_{7};
};

TEST(Shapes, DistancesAreThoseOfTheTextbook) {
  const auto distance = [](const ConvexShape& shape, const ShapePoint& a) { return distance_to(shape, a).distance; };
  EXPECT_DOUBLE_EQ(distance(kAHalfSpace, {3, 0.25, -4}), 0.25);
  EXPECT_DOUBLE_EQ(distance(kAHalfSpace, {3, -0.25, -4}), -0.25);
  EXPECT_DOUBLE_EQ(distance(kASphere, {0, 3, 4}), 5 - 0.7);
  EXPECT_DOUBLE_EQ(distance(kASphere, {0, 0, 0}), -0.7);
  EXPECT_DOUBLE_EQ(distance(kACapsule, {0.3, 0.5, 0.4}), 0.5 - 0.3);  // beside the line
  EXPECT_DOUBLE_EQ(distance(kACapsule, {0.3, 0.6 + 1.2, 0.4}), 1.3 - 0.3);
  EXPECT_DOUBLE_EQ(distance(kABox, {0.9, 0.1, 0.1}), 0.5);
  EXPECT_DOUBLE_EQ(distance(kABox, {0.4 + 0.3, 0.7 + 0.4, 0.2 + 1.2}), 1.3);
  EXPECT_NEAR(distance(kABox, {0.1, 0.1, 0.15}), -0.05, 1e-15);
  EXPECT_DOUBLE_EQ(distance(kACylinder, {0.6, 0.1, 0.8}), 1 - 0.4);
  EXPECT_DOUBLE_EQ(distance(kACylinder, {0.42, 0.6 + 0.4, 0.56}), 0.5);  // .3 beside the rim, .4 above it
  EXPECT_NEAR(distance(kACylinder, {0.1, 0.5, 0}), -0.1, 1e-15);
}

TEST(Shapes, TheNormalIsTheGradientOfTheDistanceAndLeadsToTheSurface) {
  ShapePoints points;
  for (const ConvexShape& shape : kAllShapes)
    for (int k = 0; k < 2000; ++k) {
      const ShapePoint a = points.next();
      const SurfaceDistance<double> at = distance_to(shape, a);
      ASSERT_NEAR(norm(at.normal), 1, 1e-12);
      ASSERT_NEAR(distance_to(shape, a - at.normal * at.distance).distance, 0, 1e-12);
      constexpr double h = 1e-6;
      const ShapePoint way = points.next(1);
      const double ahead = distance_to(shape, a + way * h).distance, behind = distance_to(shape, a - way * h).distance;
      // Near the edges of a shape's medial axis the distance has a kink, within which a difference is no gradient.
      if (std::abs(ahead - 2 * at.distance + behind) < 1e-10) {
        ASSERT_NEAR((ahead - behind) / (2 * h), dot(at.normal, way), 1e-3);
      }
    }
}

TEST(Shapes, DistancesAreConvexAlongPaths) {
  ShapePoints points;
  for (const ConvexShape& shape : kAllShapes)
    for (int k = 0; k < 2000; ++k) {
      const ShapePoint a = points.next(), b = points.next();
      const double middle = distance_to(shape, (a + b) * 0.5).distance;
      ASSERT_LE(middle, 0.5 * (distance_to(shape, a).distance + distance_to(shape, b).distance) + 1e-12);
    }
}

TEST(Shapes, APathMeetsASphereWhereTheQuadraticEquationSays) {
  ShapePoints points;
  int met = 0;
  for (int k = 0; k < 5000; ++k) {
    const ShapePoint a = points.next(3), way = points.next(3) - a;
    const SurfaceDistance<double> start = distance_to(kASphere, a);
    if (start.distance <= 0) continue;
    const double qa = dot(way, way), qb = dot(a, way), qc = dot(a, a) - 0.49, under = qb * qb - qa * qc;
    const PathPoint<double> end = advance_to(kASphere, a, way, start, 0.0, 1e-12);
    const bool grazes = std::abs(under) < 1e-3 * qa;
    const double t = under > 0 ? (-qb - std::sqrt(under)) / qa : 2;
    if (under > 0 && t >= 0 && t <= 1 && !grazes) {
      ++met;
      ASSERT_NEAR(end.t, t, 1e-9);
      ASSERT_NEAR(end.at.distance, 0, 1e-11);
    } else if (!grazes) {
      ASSERT_GT(end.at.distance, 1e-12);
    }
  }
  EXPECT_GT(met, 300);
}

TEST(Shapes, NothingOfAPathBeforeItsEndIsNearerThanTheLevel) {
  ShapePoints points;
  for (const ConvexShape& shape : kAllShapes)
    for (int k = 0; k < 3000; ++k) {
      const ShapePoint a = points.next(2), way = points.next(2) - a;
      const double level = 0.05;
      const SurfaceDistance<double> start = distance_to(shape, a);
      if (start.distance < level) continue;
      const PathPoint<double> end = advance_to(shape, a, way, start, level, 1e-9);
      for (int s = 0; s <= 20; ++s) ASSERT_GE(distance_to(shape, a + way * (end.t * s / 20)).distance, level - 1e-12);
      // What the path does after that, the plane at its end says: it has the shape behind it.
      const ShapePoint q = a + way * end.t - end.at.normal * end.at.distance;
      for (int s = 0; s < 20; ++s) {
        const ShapePoint any = points.next(1);
        const SurfaceDistance<double> near = distance_to(shape, any);
        ASSERT_LE(dot(end.at.normal, any - near.normal * near.distance - q), 1e-9);
      }
    }
}

TEST(Shapes, ABoxOfParticlesIsNoNearerThanItsBound) {
  ShapePoints points;
  for (const ConvexShape& shape : kAllShapes)
    for (int k = 0; k < 500; ++k) {
      const ShapePoint centre = points.next(2), any = points.next(0.3);
      const ShapePoint half{std::abs(any.x), std::abs(any.y), std::abs(any.z)};
      const double bound = distance_to_box(shape, centre, half);
      double nearest = INFINITY;
      for (int s = 0; s < 200; ++s) {
        const ShapePoint r = points.next(1);
        nearest = std::min(nearest,
                           distance_to(shape, centre + ShapePoint{r.x * half.x, r.y * half.y, r.z * half.z}).distance);
      }
      if (bound > 0) {
        ASSERT_GE(nearest, bound - 1e-12);
      }
    }
}

#if !defined(__CUDACC__)
TEST(Shapes, APackGivesTheBitsOfItsLanes) {
  using Lanes = Pack<double, 32>;
  ShapePoints points;
  for (const ConvexShape& shape : kAllShapes)
    for (int k = 0; k < 500; ++k) {
      Vector3<Lanes> a, way;
      ShapePoint from[4], ways[4];
      for (int l = 0; l < 4; ++l) {
        from[l] = points.next(2), ways[l] = points.next(2) - from[l];
        set_lane(a.x, l, from[l].x), set_lane(a.y, l, from[l].y), set_lane(a.z, l, from[l].z);
        set_lane(way.x, l, ways[l].x), set_lane(way.y, l, ways[l].y), set_lane(way.z, l, ways[l].z);
      }
      const PathPoint<Lanes> end = advance_to(shape, a, way, distance_to(shape, a), Lanes(0.01), 1e-9);
      for (int l = 0; l < 4; ++l) {
        const PathPoint<double> one = advance_to(shape, from[l], ways[l], distance_to(shape, from[l]), 0.01, 1e-9);
        ASSERT_EQ(lane(end.t, l), one.t);
        ASSERT_EQ(lane(end.at.distance, l), one.at.distance);
        ASSERT_EQ(lane(end.at.normal.y, l), one.at.normal.y);
      }
    }
}
#endif

TEST(Shapes, ArePlacedByTheirTransformAndDrawnWhereTheyAre) {
  Transform turned;
  turned.translate = {0.3, -0.2, 0.5}, turned.axis = {1, 2, -1}, turned.degrees = 70, turned.scale = {2, 2, 2};
  const std::vector<Vec3> bodies{{-1, 0, -1}, {1, 1, 1}};
  const Shape shapes[]{SphereShape{0.4, std::nullopt}, BoxShape{{1, 2, 0.5}, std::nullopt},
                       CapsuleShape{{0.1, 0, 0}, {0.4, 0.5, 0.6}, 0.2}, CylinderShape{{0.1, 0, 0}, {0.1, -1, 0}, 0.2},
                       PlaneShape{}};
  for (const Shape& shape : shapes) {
    const PlacedShape placed = place(shape, turned);
    const Mesh mesh = drawing_of(shape, turned, bodies);
    ASSERT_FALSE(mesh.faces.empty());
    for (const Vec3& x : mesh.points)
      ASSERT_NEAR(distance_to(placed.shape, to_local(placed.pose, ShapePoint{x[0], x[1], x[2]})).distance, 0, 1e-12)
          << shape.index();
    // The faces look outwards.
    for (const Quad& face : mesh.faces) {
      const auto corner = [&](int k) {
        return ShapePoint{mesh.points[face[k]][0], mesh.points[face[k]][1], mesh.points[face[k]][2]};
      };
      const ShapePoint middle = (corner(0) + corner(1) + corner(2)) * (1.0 / 3),
                       normal = cross(corner(1) - corner(0), corner(2) - corner(0));
      const SurfaceDistance<double> near = distance_to(placed.shape, to_local(placed.pose, middle));
      ASSERT_GT(dot(rotate(placed.pose, near.normal), normal), 0) << shape.index();
    }
  }
}

}  // namespace
}  // namespace malha
