// SPDX-License-Identifier: Apache-2.0
#include "host/model/exact_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/mesh/bounding_box.h"
#include "host/mesh/generate.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

using Point = Vector3<double>;

Point point(const Vec3& a) { return {a[0], a[1], a[2]}; }

/// The rotation and translation of a transform, without its scale.
Pose pose_of(const Transform& transform) {
  if (transform.degrees == 0 && transform.translate == Vec3{0, 0, 0}) return {};
  const double angle = transform.degrees * std::numbers::pi / 180;
  const Eigen::Vector3d axis = Eigen::Vector3d(transform.axis.data()).normalized();
  const Eigen::Matrix3d r = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  Pose pose;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) pose.r[3 * i + k] = r(i, k);
  pose.t = point(transform.translate), pose.moves = true;
  return pose;
}

/// The pose of a frame whose y axis points from one point to another, with its origin in the middle.
Pose pose_between(const Point& from, const Point& to) {
  const Point line = to - from, y = line * (1 / norm(line));
  const Point other = std::abs(y.x) < 0.5 ? Point{1, 0, 0} : Point{0, 0, 1};
  Point z = cross(other, y);
  z = z * (1 / norm(z));
  const Point x = cross(y, z);
  Pose pose;
  const Point columns[]{x, y, z};
  for (int k = 0; k < 3; ++k) pose.r[k] = columns[k].x, pose.r[3 + k] = columns[k].y, pose.r[6 + k] = columns[k].z;
  pose.t = (from + to) * 0.5, pose.moves = true;
  return pose;
}

}  // namespace

Pose composed(const Pose& first, const Pose& second) {
  if (!first.moves) return second;
  if (!second.moves) return first;
  Pose both;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      double& sum = both.r[3 * row + column] = 0;
      for (int k = 0; k < 3; ++k) sum += first.r[3 * row + k] * second.r[3 * k + column];
    }
  both.t = to_world(first, second.t), both.moves = true;
  return both;
}

PlacedShape place(const Shape& shape, const Transform& transform) {
  const Vec3& scale = transform.scale;
  const Pose pose = pose_of(transform);
  if (const auto* sphere = std::get_if<SphereShape>(&shape))
    return {{ConvexKind::RoundedBox, {0, 0, 0}, sphere->radius * scale[0]}, pose};
  if (const auto* box = std::get_if<BoxShape>(&shape)) {
    const Vec3& size = box->size;
    return {{ConvexKind::RoundedBox, {size[0] * scale[0] / 2, size[1] * scale[1] / 2, size[2] * scale[2] / 2}, 0},
            pose};
  }
  const auto between = [&](ConvexKind kind, const auto& line) {
    const Point from = point(line.from) * scale[0], to = point(line.to) * scale[0];
    return PlacedShape{{kind, {0, norm(to - from) / 2, 0}, line.radius * scale[0]},
                       composed(pose, pose_between(from, to))};
  };
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) return between(ConvexKind::RoundedBox, *capsule);
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) return between(ConvexKind::Cylinder, *cylinder);
  return {{}, pose};
}

Mesh drawing_of(const Shape& shape, const Transform& transform, const std::vector<Vec3>& bodies) {
  Mesh mesh;
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
    mesh = generate(SphereShape{sphere->radius, 4});
  } else if (const auto* box = std::get_if<BoxShape>(&shape)) {
    mesh = generate(BoxShape{box->size, {{1, 1, 1}}});
  } else if (!std::holds_alternative<PlaneShape>(shape)) {
    mesh = generate(shape);
  } else {
    constexpr double kBodies = 4;  // half the square's side by the extent of the bodies
    const Pose pose = pose_of(transform);
    const auto [low, high] = bounds_of(bodies);
    const Point centre = to_local(pose, (point(low) + point(high)) * 0.5);
    const double extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
    const double half = kBodies * std::max(extent, std::abs(centre.y) / kBodies);
    mesh = generate(shape);
    for (Vec3& at : mesh.points) {
      const Point a = to_world(pose, {centre.x + at[0] * half, 0, centre.z + at[2] * half});
      at = {a.x, a.y, a.z};
    }
    return mesh;
  }
  apply(transform, mesh);
  return mesh;
}

}  // namespace malha
