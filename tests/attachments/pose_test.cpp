// SPDX-License-Identifier: Apache-2.0
#include "host/attachments/pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

using V = Vector3<double>;

Keyframe at(double time, const Vec3& translate, const Vec3& axis = {0, 1, 0}, double degrees = 0) {
  return {time, translate, axis, degrees};
}

void expect_near(const V& found, const V& expected) { EXPECT_LT(norm(found - expected), 1e-12); }

/// The image of x under a rotation by `degrees` about a coordinate axis, counter-clockwise seen from its tip.
V turned_about_y(const V& x, double degrees) {
  const double a = degrees * std::numbers::pi / 180;
  return {std::cos(a) * x.x + std::sin(a) * x.z, x.y, -std::sin(a) * x.x + std::cos(a) * x.z};
}

void expect_rotation(const Pose& pose) {
  const V rows[3] = {
      {pose.r[0], pose.r[1], pose.r[2]}, {pose.r[3], pose.r[4], pose.r[5]}, {pose.r[6], pose.r[7], pose.r[8]}};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(dot(rows[i], rows[k]), i == k, 1e-14);
  EXPECT_NEAR(dot(cross(rows[0], rows[1]), rows[2]), 1, 1e-14);
}

TEST(PoseAt, IsTheIdentityWithoutMotion) {
  const Pose pose = pose_at({}, 3);
  const V x{1, 2, 3};
  EXPECT_TRUE(same_bits(to_world(pose, x), x));
  EXPECT_TRUE(same_bits(to_local(pose, x), x));
}

TEST(PoseAt, IsLinearInTranslation) {
  const std::vector<Keyframe> motion{at(1, {0, 0, 0}), at(3, {4, -2, 6}), at(4, {4, -2, 0})};
  expect_near(pose_at(motion, 1.5).t, {1, -0.5, 1.5});
  expect_near(pose_at(motion, 3).t, {4, -2, 6});
  expect_near(pose_at(motion, 3.5).t, {4, -2, 3});
}

TEST(PoseAt, RestsBeforeTheFirstAndAfterTheLastKeyframe) {
  const std::vector<Keyframe> motion{at(1, {1, 2, 3}, {0, 1, 0}, 30), at(3, {4, 5, 6}, {0, 1, 0}, 50)};
  for (const double time : {-1.0, 0.0, 0.999, 1.0}) {
    expect_near(pose_at(motion, time).t, {1, 2, 3});
    expect_near(rotate(pose_at(motion, time), {1, 0, 0}), turned_about_y({1, 0, 0}, 30));
  }
  for (const double time : {3.0, 3.001, 1e6}) {
    expect_near(pose_at(motion, time).t, {4, 5, 6});
    expect_near(rotate(pose_at(motion, time), {1, 0, 0}), turned_about_y({1, 0, 0}, 50));
  }
  expect_near(pose_at({at(5, {1, 2, 3})}, 0).t, {1, 2, 3});
}

TEST(PoseAt, CountsWholeTurns) {
  const std::vector<Keyframe> motion{at(0, {0, 0, 0}), at(2, {0, 0, 0}, {0, 5, 0}, 720),
                                     at(4, {0, 0, 0}, {0, 1, 0}, -360)};
  for (const double time : {0.0, 0.1, 0.25, 0.5, 1.3, 2.0})
    expect_near(rotate(pose_at(motion, time), {1, 0.5, 0}), turned_about_y({1, 0.5, 0}, 360 * time));
  for (const double time : {2.1, 3.0, 3.9})
    expect_near(rotate(pose_at(motion, time), {1, 0.5, 0}), turned_about_y({1, 0.5, 0}, 720 - 540 * (time - 2)));
}

TEST(PoseAt, TakesTheAxisOfTheOtherKeyframeWhereOneDoesNotTurn) {
  // A turn by 0 has no axis: by 0 about x, then by 180 about z, is a turn about z all the way.
  for (const bool backwards : {false, true}) {
    std::vector<Keyframe> motion{at(0, {0, 0, 0}, {1, 0, 0}, 0), at(1, {0, 0, 0}, {0, 0, 1}, 540)};
    if (backwards) std::swap(motion[0], motion[1]), motion[0].time = 0, motion[1].time = 1;
    const double turn = (backwards ? 0.75 : 0.25) * 3 * std::numbers::pi;
    expect_near(rotate(pose_at(motion, 0.25), {1, 0, 0}), {std::cos(turn), std::sin(turn), 0});
  }
}

TEST(PoseAt, TurnsTheShortestWayBetweenDifferentAxes) {
  const std::vector<Keyframe> motion{at(0, {0, 0, 0}, {1, 0, 0}, 90), at(1, {0, 0, 0}, {0, 1, 0}, 90)};
  const auto quaternion = [&](double time) {
    const Pose pose = pose_at(motion, time);
    expect_rotation(pose);
    return Eigen::Quaterniond(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.r).eval());
  };
  // The rotation between the two keyframes is 120 degrees, and equal times are equal angles.
  EXPECT_NEAR(quaternion(0).angularDistance(quaternion(1)), 2 * std::numbers::pi / 3, 1e-12);
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(quaternion(i * 0.25).angularDistance(quaternion((i + 1) * 0.25)), std::numbers::pi / 6, 1e-12);
}

TEST(PoseAt, JumpsWhereTwoKeyframesHaveOneTime) {
  const std::vector<Keyframe> motion{at(0, {0, 0, 0}), at(1, {1, 0, 0}), at(1, {5, 0, 0}), at(2, {6, 0, 0})};
  expect_near(pose_at(motion, 0.999999999999999).t, {1, 0, 0});
  expect_near(pose_at(motion, 1).t, {5, 0, 0});
  expect_near(pose_at(motion, 1.5).t, {5.5, 0, 0});
}

TEST(PoseAt, IsARotationWhateverTheAxis) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Keyframe> motion;
    for (int k = 0; k < 3; ++k) {
      const V axis = random.direction() * random(0.01, 100), to = random.in_cube(10);
      motion.push_back(at(k, {to.x, to.y, to.z}, {axis.x, axis.y, axis.z}, random(-1000, 1000)));
    }
    const Pose pose = pose_at(motion, random(-0.5, 2.5));
    expect_rotation(pose);
    const V x = random.in_cube(10);
    expect_near(to_local(pose, to_world(pose, x)), x);
    expect_near(to_world(pose, to_local(pose, x)), x);
    expect_near(to_world(pose, x) - to_world(pose, {0, 0, 0}), rotate(pose, x));
  }
}

}  // namespace
}  // namespace malha
