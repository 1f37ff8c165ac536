// SPDX-License-Identifier: Apache-2.0
#include "host/render/view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/render/picture.h"

namespace malha {

namespace {

struct Basis {
  Eigen::Vector3d right, up, forward;
};

/// Returns the basis of a camera with this view direction and y up; for a vertical direction -z is up, as on a map.
Basis basis_along(Eigen::Vector3d direction) {
  if (!(direction.norm() > 0)) direction = {0, 0, -1};
  const Eigen::Vector3d forward = direction.normalized();
  Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitY());
  if (right.norm() < 1e-6) right = Eigen::Vector3d::UnitX();
  right.normalize();
  return {right, right.cross(forward), forward};
}

double half_height(const Camera& camera) { return std::tan(camera.fov_degrees * std::numbers::pi / 360); }

}  // namespace

Lens::Lens(const Camera& camera, int image_width, int image_height)
    : width(static_cast<float>(image_width)), height(static_cast<float>(image_height)) {
  const Eigen::Vector3d from(camera.eye.data()), to(camera.target.data());
  const Basis basis = basis_along(to - from);
  eye = from.cast<float>();
  right = basis.right.cast<float>();
  up = basis.up.cast<float>();
  forward = basis.forward.cast<float>();
  pixel = static_cast<float>(2 * half_height(camera) / image_height);
}

/// The eye is as near as the four planes of the frustum allow: a point with coordinates (r, u, f) along the basis is
/// inside if |r - r_eye| <= a (f - f_eye) and |u - u_eye| <= b (f - f_eye).
Camera frame_all(std::span<const std::array<float, 3>> points, double aspect, const Vec3& direction) {
  constexpr double kMargin = 0.9;  // share of the picture that the points may fill
  Camera camera;
  camera.fov_degrees = 30;
  const Basis basis = basis_along(Eigen::Vector3d(direction.data()));
  const double b = kMargin * half_height(camera), a = b * aspect;
  const double lowest = std::numeric_limits<double>::lowest();
  double left = lowest, right = lowest, bottom = lowest, top = lowest, near = -lowest, far = lowest;
  Eigen::AlignedBox3d box;
  for (const auto& point : points) {
    const Eigen::Vector3d p(point[0], point[1], point[2]);
    if (!p.allFinite()) continue;
    const double r = p.dot(basis.right), u = p.dot(basis.up), f = p.dot(basis.forward);
    box.extend(p);
    right = std::max(right, r - a * f);
    left = std::max(left, -r - a * f);
    top = std::max(top, u - b * f);
    bottom = std::max(bottom, -u - b * f);
    near = std::min(near, f);
    far = std::max(far, f);
  }
  if (box.isEmpty()) return {};
  const double size = box.sizes().norm();
  const double room =
      size > 0 ? 0.05 * size : 2;  // m, between the eye and the nearest point; a single point has no size
  const double f = std::min({-(right + left) / (2 * a), -(top + bottom) / (2 * b), near - room});
  const Eigen::Vector3d eye = 0.5 * (right - left) * basis.right + 0.5 * (top - bottom) * basis.up + f * basis.forward;
  const Eigen::Vector3d target = eye + (0.5 * (near + far) - f) * basis.forward;
  std::copy_n(eye.data(), 3, camera.eye.begin());
  std::copy_n(target.data(), 3, camera.target.begin());
  return camera;
}

}  // namespace malha
