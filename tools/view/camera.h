// SPDX-License-Identifier: Apache-2.0
// Orbit camera of the window (y is up), with projection and unprojection of pixels.
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>

#include "malha/scene.h"

namespace malha::view {

using Point3f = std::array<float, 3>;  // m
inline Point3f to_point3f(const Vec3& a) { return {float(a[0]), float(a[1]), float(a[2])}; }

/// Pixels count from the top left corner.
struct Viewport {
  int left = 0, top = 0, width = 1, height = 1;
  double aspect() const { return double(width) / height; }
  bool contains(double x, double y) const { return x >= left && y >= top && x < left + width && y < top + height; }
};

/// A ray from the eye with unit direction.
struct Ray {
  Eigen::Vector3d from, direction;
};

class OrbitCamera {
 public:
  OrbitCamera() : OrbitCamera(Camera{}) {}
  explicit OrbitCamera(const Camera& camera);
  /// Shows the whole picture of this camera, of aspect ratio `of_picture`, in a viewport of aspect ratio `of_port`,
  /// which may be narrower.
  OrbitCamera(const Camera& camera, double of_picture, double of_port);

  /// Rotates about the target, radians.
  void orbit(double right, double up);
  /// Moves camera and target, in multiples of the picture's height.
  void pan(double right, double up);
  /// Multiplies the distance to the target.
  void zoom(double factor);
  /// Frames all the finite points from the present direction.
  void frame(std::span<const Point3f> points, double aspect);

  Eigen::Vector3d eye() const { return target_ + distance_ * backward(); }
  double distance() const { return distance_; }  // m, from the eye to the target
  Eigen::Vector3d right() const;
  Eigen::Vector3d up() const;
  Eigen::Vector3d backward() const;

  /// Matrices from world to eye coordinates, and from eye coordinates to OpenGL's clip space.
  Eigen::Matrix4d view() const;
  Eigen::Matrix4d projection(double aspect) const;

  Ray ray(const Viewport& port, double x, double y) const;
  /// Projects a point to pixels, with its depth along the view direction (m; negative behind the eye).
  Eigen::Vector3d on_screen(const Viewport& port, const Eigen::Vector3d& point) const;
  /// Returns the size of a pixel at this depth, m.
  double metres_per_pixel(const Viewport& port, double depth) const;
  /// Returns the point under a pixel at this depth.
  Eigen::Vector3d at(const Viewport& port, double x, double y, double depth) const;

 private:
  Eigen::Vector3d target_;
  double distance_, yaw_, pitch_, fov_;  // m, radians
};

}  // namespace malha::view
