// SPDX-License-Identifier: Apache-2.0
// Pose of a rigid mesh on keyframes.
#pragma once
#include <vector>

#include "kernels/attachments/pose.h"
#include "malha/scene.h"

namespace malha {

/// Interpolates keyframes: linearly in translation; about a common axis linearly in the angle (whole turns count),
/// otherwise by the shortest slerp. Before the first and after the last keyframe the mesh rests. No keyframe: identity.
Pose pose_at(const std::vector<Keyframe>& motion, double time);

/// The pose as a rotation about an axis and a translation.
RigidPose rigid_pose_of(const Pose& pose);
/// The keyframe at a time (s) of a motion, which poses the mesh as pose_at() does.
Keyframe keyframe_at(const std::vector<Keyframe>& motion, double time);

/// The motion from the world to the world that takes the pose `before` to `after`.
Pose from_to(const Pose& before, const Pose& after);

}  // namespace malha
