// SPDX-License-Identifier: Apache-2.0
#include "tools/view/camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace malha::view {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSteepest = 0.499 * kPi;  // at the pole the up direction is undefined

Eigen::Vector3d vector(const Vec3& a) { return {a[0], a[1], a[2]}; }

}  // namespace

OrbitCamera::OrbitCamera(const Camera& camera) : target_(vector(camera.target)), fov_(camera.fov_degrees * kPi / 180) {
  const Eigen::Vector3d away = vector(camera.eye) - target_;
  distance_ = std::max(away.norm(), 1e-6);
  pitch_ = std::clamp(std::asin(std::clamp(away.y() / distance_, -1.0, 1.0)), -kSteepest, kSteepest);
  yaw_ = std::atan2(away.x(), away.z());
}

OrbitCamera::OrbitCamera(const Camera& camera, double of_picture, double of_port) : OrbitCamera(camera) {
  fov_ = 2 * std::atan(std::tan(fov_ / 2) * std::max(1.0, of_picture / of_port));
}

void OrbitCamera::orbit(double right, double up) {
  yaw_ = std::remainder(yaw_ - right, 2 * kPi);
  pitch_ = std::clamp(pitch_ + up, -kSteepest, kSteepest);
}

void OrbitCamera::pan(double right, double up) {
  const double height = 2 * distance_ * std::tan(fov_ / 2);
  target_ -= height * (right * this->right() + up * this->up());
}

void OrbitCamera::zoom(double factor) { distance_ = std::clamp(distance_ * factor, 1e-6, 1e9); }

void OrbitCamera::frame(std::span<const Point3f> points, double aspect) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (const Point3f& point : points) {
    const Eigen::Vector3d x(point[0], point[1], point[2]);
    if (!x.allFinite()) continue;
    low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  if (!(low.x() <= high.x())) return;
  target_ = (low + high) / 2;
  const double radius = std::max((high - low).norm() / 2, 1e-4);
  const double narrow = std::atan(std::tan(fov_ / 2) * std::min(1.0, aspect));
  distance_ = 1.05 * radius / std::sin(narrow);
}

Eigen::Vector3d OrbitCamera::right() const { return {std::cos(yaw_), 0, -std::sin(yaw_)}; }
Eigen::Vector3d OrbitCamera::up() const { return backward().cross(right()); }
Eigen::Vector3d OrbitCamera::backward() const {
  return {std::cos(pitch_) * std::sin(yaw_), std::sin(pitch_), std::cos(pitch_) * std::cos(yaw_)};
}

Eigen::Matrix4d OrbitCamera::view() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.block<1, 3>(0, 0) = right().transpose();
  matrix.block<1, 3>(1, 0) = up().transpose();
  matrix.block<1, 3>(2, 0) = backward().transpose();
  matrix.block<3, 1>(0, 3) = -matrix.block<3, 3>(0, 0) * eye();
  return matrix;
}

Eigen::Matrix4d OrbitCamera::projection(double aspect) const {
  const double near = 0.01 * distance_, far = 100 * distance_, f = 1 / std::tan(fov_ / 2);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  matrix(0, 0) = f / aspect, matrix(1, 1) = f;
  matrix(2, 2) = (far + near) / (near - far), matrix(2, 3) = 2 * far * near / (near - far), matrix(3, 2) = -1;
  return matrix;
}

Ray OrbitCamera::ray(const Viewport& port, double x, double y) const {
  return {eye(), (at(port, x, y, 1) - eye()).normalized()};
}

Eigen::Vector3d OrbitCamera::on_screen(const Viewport& port, const Eigen::Vector3d& point) const {
  const Eigen::Vector3d away = point - eye();
  const double depth = -away.dot(backward()), pixel = metres_per_pixel(port, std::max(depth, 1e-12));
  return {port.left + port.width / 2.0 + away.dot(right()) / pixel,
          port.top + port.height / 2.0 - away.dot(up()) / pixel, depth};
}

double OrbitCamera::metres_per_pixel(const Viewport& port, double depth) const {
  return 2 * depth * std::tan(fov_ / 2) / port.height;
}

Eigen::Vector3d OrbitCamera::at(const Viewport& port, double x, double y, double depth) const {
  const double pixel = metres_per_pixel(port, depth);
  return eye() - depth * backward() + (x - port.left - port.width / 2.0) * pixel * right() +
         (port.top + port.height / 2.0 - y) * pixel * up();
}

}  // namespace malha::view
