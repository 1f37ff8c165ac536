// SPDX-License-Identifier: Apache-2.0
// The motion of a particle over a substep, for one particle or a pack of them (Müller et al. 2006, section 3.1).
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

/// v + dt g, where `dt` is the substep h, here and in the functions below. Pinned particles (w = 0) stay at rest.
template <class S>
KERNEL Vector3<S> apply_gravity(const Vector3<S>& v, S w, const Vector3<S>& g, S dt) {
  const S zero(typename RealOf<S>::type(0));
  return v + g * select(w > zero, dt, zero);
}

/// x + dt v.
template <class S>
KERNEL Vector3<S> predicted(const Vector3<S>& x, const Vector3<S>& v, S dt) {
  return x + v * dt;
}

/// d = dt v; pinned particles keep their prescribed displacement.
template <class S>
KERNEL Vector3<S> predicted_displacement(S w, const Vector3<S>& v, const Vector3<S>& prescribed, S dt) {
  const auto pinned = w <= S(typename RealOf<S>::type(0));
  return {select(pinned, prescribed.x, v.x * dt), select(pinned, prescribed.y, v.y * dt),
          select(pinned, prescribed.z, v.z * dt)};
}

/// v = d / dt, as a correction of the velocity of the prediction: particles that no constraint moved keep their
/// velocity to the bit, however many substeps there are.
template <class S>
KERNEL Vector3<S> velocity_from_positions(const Vector3<S>& v, const Vector3<S>& d, S dt, S per_dt) {
  return v + (d - v * dt) * per_dt;
}

/// 0 if every coordinate is finite, otherwise NaN.
template <class S>
KERNEL S zero_if_finite(const Vector3<S>& a) {
  return (a.x + a.y + a.z) * S(typename RealOf<S>::type(0));
}

}  // namespace malha
