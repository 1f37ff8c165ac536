// SPDX-License-Identifier: Apache-2.0
// Rigid motion that restores the momenta of truncated bodies without adding energy.
#pragma once
#include "kernels/self_collision/rigid_sums.h"
#include "malha/mesh.h"

namespace malha {

/// Fits the correction that restores the momenta before truncation. If bodies would have more energy than before it,
/// the motion relative to the rigid one is slowed down; and if the rotation alone had more, since the inertia has
/// changed, it is slowed down too.
RigidCorrection fit_rigid_momentum(const TruncationSums& sums);

}  // namespace malha
