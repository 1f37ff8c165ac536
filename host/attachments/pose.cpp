// SPDX-License-Identifier: Apache-2.0
#include "host/attachments/pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

namespace malha {

namespace {

Eigen::Vector3d axis_of(const Keyframe& key) { return Eigen::Vector3d(key.axis.data()).normalized(); }

Eigen::Quaterniond turn(const Eigen::Vector3d& axis, double degrees) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis));
}

Eigen::Quaterniond turn_between(const Keyframe& a, const Keyframe& b, double s) {
  const Eigen::Vector3d from = a.degrees == 0 ? axis_of(b) : axis_of(a);  // a zero turn fits any axis
  const Eigen::Vector3d to = b.degrees == 0 ? from : axis_of(b);
  if ((from - to).norm() < 1e-12) return turn(from, a.degrees + s * (b.degrees - a.degrees));
  return turn(from, a.degrees).slerp(s, turn(to, b.degrees));
}

}  // namespace

Pose pose_at(const std::vector<Keyframe>& motion, double time) {
  Pose pose;
  if (motion.empty()) return pose;
  const auto next = std::ranges::find_if(motion, [time](const Keyframe& key) { return key.time > time; });
  const Keyframe& b = next == motion.end() ? motion.back() : *next;
  const Keyframe& a = next == motion.begin() ? b : *(next - 1);
  const double s = b.time > a.time ? (time - a.time) / (b.time - a.time) : 0;

  const Eigen::Matrix3d r = turn_between(a, b, s).toRotationMatrix();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) pose.r[3 * i + k] = r(i, k);
  const auto mix = [&](int k) { return a.translate[k] + s * (b.translate[k] - a.translate[k]); };
  pose.t = {mix(0), mix(1), mix(2)};
  pose.moves = true;
  return pose;
}

RigidPose rigid_pose_of(const Pose& pose) {
  const Eigen::AngleAxisd turned(
      Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.r)));
  const Eigen::Vector3d& axis = turned.axis();
  return {{pose.t.x, pose.t.y, pose.t.z}, {axis[0], axis[1], axis[2]}, turned.angle() * 180 / std::numbers::pi};
}

Keyframe keyframe_at(const std::vector<Keyframe>& motion, double time) {
  const RigidPose pose = rigid_pose_of(pose_at(motion, time));
  return {time, pose.translate, pose.axis, pose.degrees};
}

Pose from_to(const Pose& before, const Pose& after) {
  Pose motion;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      double& sum = motion.r[3 * row + column] = 0;
      for (int k = 0; k < 3; ++k) sum += after.r[3 * row + k] * before.r[3 * column + k];
    }
  motion.moves = true;
  motion.t = after.t - rotate(motion, before.t);
  return motion;
}

}  // namespace malha
