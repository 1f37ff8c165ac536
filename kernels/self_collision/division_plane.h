// SPDX-License-Identifier: Apache-2.0
// Division plane of a pair of primitives (a particle and a triangle, or two edges): the extent of both sides along its
// normal, and the gap that must stay open between them. Self-collision and contacts with edges of the environment use
// it.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// Extent of the sides of a pair along the normal of its plane, which points from the second side to the first: the
/// lowest point of the first side and the highest of the second.
template <class S>
struct ContactSides {
  S low = S(INFINITY), high = -S(INFINITY);
  /// Adds particle j at coordinate `at` along the normal; the first `first` particles are the first side.
  KERNEL void add(int j, int first, S at) {
    if (j < first)
      low = min(low, at);
    else
      high = max(high, at);
  }
};

/// The gap (m) that a pair with this gap at the start of the substep must keep at its end: a tenth of it, but at least
/// `least`, unless the gap is smaller than that already.
template <class S>
KERNEL S required_gap(const S& gap, typename RealOf<S>::type least) {
  using R = typename RealOf<S>::type;
  return min(gap, max(gap * S(R(0.1)), S(least)));
}

}  // namespace malha
