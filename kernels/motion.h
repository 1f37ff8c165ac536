// The motion of a particle over a substep, for one particle or a pack of them (Müller et al. 2006, section 3.1).
#pragma once
#include "kernels/particles.h"

namespace malha {

/// v + dt g. Pinned particles (w = 0) stay at rest.
template <class S>
KERNEL Vector3<S> accelerated(const Vector3<S>& v, S w, const Vector3<S>& g, S dt) {
  const S zero(typename RealOf<S>::type(0));
  return v + g * select(w > zero, dt, zero);
}

/// x + dt v.
template <class S>
KERNEL Vector3<S> predicted(const Vector3<S>& x, const Vector3<S>& v, S dt) {
  return x + v * dt;
}

/// v = (p - x) / dt, from the velocity that p was predicted with. Written as that velocity and what the constraints
/// changed of it: p - x is rounded to the spacing of the coordinates, and over a short dt that would outweigh gravity
/// (in float and 160 substeps a particle 2 m up would hang still).
template <class S>
KERNEL Vector3<S> changed(const Vector3<S>& x, const Vector3<S>& v, const Vector3<S>& p, S dt, S per_dt) {
  return v + (p - predicted(x, v, dt)) * per_dt;
}

/// 0 if every coordinate is finite, otherwise NaN.
template <class S>
KERNEL S zero_if_finite(const Vector3<S>& a) {
  return (a.x + a.y + a.z) * S(typename RealOf<S>::type(0));
}

}  // namespace malha
