// SPDX-License-Identifier: Apache-2.0
// Exact shapes of the environment in a substep.
#pragma once
#include <cmath>

#include "host/attachments/pose.h"
#include "host/model/exact_shape.h"

namespace malha {

/// The shape in a substep, while its object moves from its pose at `start` to that at `end` (s).
inline MovingShape moving_shape(const PlacedShape& placed, const EnvironmentSpec& spec, double start, double end) {
  MovingShape moving{placed.shape,   placed.pose,   placed.pose,     {}, true, 0,
                     spec.thickness, spec.friction, spec.restitution};
  if (spec.motion.empty()) return moving;
  const Pose before = pose_at(spec.motion, start), after = pose_at(spec.motion, end);
  moving.before = composed(before, placed.pose), moving.after = composed(after, placed.pose);
  moving.motion = from_to(before, after), moving.rests = false;
  double squared = 0;  // the Frobenius norm is an upper bound
  for (int k = 0; k < 9; ++k) squared += std::pow(moving.motion.r[k] - (k % 4 == 0), 2);
  moving.turn = std::sqrt(squared);
  return moving;
}

}  // namespace malha
