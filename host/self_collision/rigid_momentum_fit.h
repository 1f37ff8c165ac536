// SPDX-License-Identifier: Apache-2.0
// How bodies that were held back get their momenta back, without energy that they did not have.
#pragma once
#include "kernels/self_collision/rigid_sums.h"
#include "malha/mesh.h"

namespace malha {

/// v = kept v + velocity + omega x (x - centre), the centre about the origin of the sums.
struct RigidCorrection {
  double kept = 1;
  Vector3<double> centre{0, 0, 0}, velocity{0, 0, 0}, omega{0, 0, 0};  // m, m/s, 1/s
};

/// What gives the momenta back that were lost. Where bodies would have more energy than before it, what moves beside
/// the motion as a whole is slowed down; and where the turn alone would have more, as places have changed, that.
RigidCorrection fit_rigid_momentum(const TruncationSums& sums);

}  // namespace malha
