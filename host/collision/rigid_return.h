// How a body that lost momentum gets it back by moving as a whole.
#pragma once
#include <array>

#include "host/mesh.h"
#include "kernels/rigid_sums.h"

namespace malha {

/// p = to + turn (p - from), about the origin of the sums.
struct RigidMove {
  Vec3 from{}, to{};
  std::array<Vec3, 3> turn{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};  // rows
  bool moves = false;
};

/// What gives `after` the linear and angular momentum of `before`: of the same particles from the same x, with p before
/// and after something. Over half a radian it does not turn: what lost so much in a substep has no axis to trust.
RigidMove rigid_return(const RigidSums& before, const RigidSums& after);

}  // namespace malha
