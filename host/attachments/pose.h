// SPDX-License-Identifier: Apache-2.0
// Where a rigidly moving mesh is at a time.
#pragma once
#include <vector>

#include "kernels/attachments/pose.h"
#include "malha/scene.h"

namespace malha {

/// Between keyframes: linear in translation; about a common axis linear in the angle (whole turns count), otherwise
/// the shortest spherical-linear turn. Before the first and after the last it rests there. No keyframe: identity.
Pose pose_at(const std::vector<Keyframe>& motion, double time);

/// From the world to the world: where what was at rest in the one pose is in the other.
Pose from_to(const Pose& before, const Pose& after);

}  // namespace malha
