// SPDX-License-Identifier: Apache-2.0
// The camera of the window: it orbits a point, y is up. What it sees at any size of the window, and what lies under a
// pixel.
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>

#include "malha/scene.h"

namespace malha::view {

using Place = std::array<float, 3>;  // m
inline Place place_of(const Vec3& a) { return {float(a[0]), float(a[1]), float(a[2])}; }

/// Pixels count from the top left corner.
struct Viewport {
  int left = 0, top = 0, width = 1, height = 1;
  double aspect() const { return double(width) / height; }
  bool holds(double x, double y) const { return x >= left && y >= top && x < left + width && y < top + height; }
};

/// From the eye, of unit direction.
struct Ray {
  Eigen::Vector3d from, direction;
};

class OrbitCamera {
 public:
  OrbitCamera() : OrbitCamera(Camera{}) {}
  explicit OrbitCamera(const Camera& camera);
  /// Sees all of a picture of this camera, width over height `of_picture`, in a port that may be narrower.
  OrbitCamera(const Camera& camera, double of_picture, double of_port);

  /// Radians.
  void orbit(double right, double up);
  /// Shares of the picture's height.
  void pan(double right, double up);
  /// Below 1: nearer.
  void zoom(double factor);
  /// Holds all the finite points, from the same side.
  void frame(std::span<const Place> points, double aspect);

  Eigen::Vector3d eye() const { return target_ + distance_ * backward(); }
  double distance() const { return distance_; }  // m, from the eye to what it orbits
  Eigen::Vector3d right() const;
  Eigen::Vector3d up() const;
  Eigen::Vector3d backward() const;

  /// World to eye, and eye to OpenGL's clip space.
  Eigen::Matrix4d view() const;
  Eigen::Matrix4d projection(double aspect) const;

  Ray ray(const Viewport& port, double x, double y) const;
  /// Pixels, and the depth along the view (m; not above 0: behind the eye).
  Eigen::Vector3d on_screen(const Viewport& port, const Eigen::Vector3d& point) const;
  /// Of something at this depth.
  double metres_per_pixel(const Viewport& port, double depth) const;
  /// The point that lies under a pixel at this depth.
  Eigen::Vector3d at(const Viewport& port, double x, double y, double depth) const;

 private:
  Eigen::Vector3d target_;
  double distance_, yaw_, pitch_, fov_;  // m, radians
};

}  // namespace malha::view
