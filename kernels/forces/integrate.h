// SPDX-License-Identifier: Apache-2.0
// The particle passes of a PBD step: external forces, prediction, and the new state (Müller et al. 2006, section 3.1).
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

/// v + dt g, where `dt` is the substep h, here and in the functions below. Pinned particles (w = 0) stay at rest.
template <class S>
KERNEL Vector3<S> apply_gravity(const Vector3<S>& v, S w, const Vector3<S>& g, S dt) {
  const S zero(0);
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
  const auto pinned = w <= S(0);
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
  return (a.x + a.y + a.z) * S(0);
}

/// v += dt g; d = dt v. Pinned particles keep their prescribed displacement.
template <class R>
struct Predict {
  Particles<R> particles;
  R dt;                // the substep h, s
  Vector3<R> gravity;  // m/s^2
  KERNEL void operator()(int i) const {
    const Vector3<R> v = apply_gravity(particles.v[i], particles.w[i], gravity, dt);
    particles.v.set(i, v);
    particles.p.d.set(i, predicted_displacement(particles.w[i], v, particles.p.d[i], dt));
  }
};

/// d += a correction, of particles that are not pinned.
template <class R>
struct AddDisplacement {
  Particles<R> particles;
  Points<R> correction;  // m
  KERNEL void operator()(int i) const {
    if (particles.w[i] > R(0)) particles.p.add_displacement(i, correction[i]);
  }
};

/// Viscous drag towards the wind, b (u - v), implicit in v so that it is stable for any b: v = (v + h u) / (1 + h),
/// h = dt w b.
template <class R>
struct Drag {
  Particles<R> particles;
  R dt, drag;       // the substep h, s; N s/m
  Vector3<R> wind;  // u, m/s
  KERNEL void operator()(int i) const {
    const R h = dt * drag * particles.w[i];
    particles.v.set(i, (particles.v[i] + wind * h) * (R(1) / (R(1) + h)));
  }
};

/// v += dt w f, of forces that a program sets.
template <class R>
struct ApplyForces {
  Particles<R> particles;
  Points<R> force;  // N
  R dt;             // the substep h, s
  KERNEL void operator()(int i) const { particles.v.set(i, particles.v[i] + force[i] * (dt * particles.w[i])); }
};

/// Makes positions the start of the next motion: x += d, d = 0.
template <class R>
struct AdvanceAll {
  Displaced<R> p;
  KERNEL void operator()(int i) const { p.advance_x(i), p.clear_displacement(i); }
};

/// An origin near each body: the position of its first particle.
template <class R>
struct SetOrigins {
  Points<R> x;
  const int* first;
  Points<R> origins;
  KERNEL void operator()(int k) const { origins.set(k, x[first[k]]); }
};

/// Reduction to the lowest index with a property; none: larger than every index.
struct FirstIndex {
  int index = 0x7fffffff;
  KERNEL FirstIndex& operator+=(const FirstIndex& other) {
    if (other.index < index) index = other.index;
    return *this;
  }
};

/// v = d / dt, x += d, d = 0. Returns the index of the particle if its position is not finite.
template <class R>
struct UpdateState {
  Particles<R> particles;
  R dt, per_dt;  // the substep h, s, and 1 / h
  KERNEL FirstIndex operator()(int i) const {
    particles.v.set(i, velocity_from_positions(particles.v[i], particles.p.d[i], dt, per_dt));
    particles.p.advance_x(i), particles.p.clear_displacement(i);
    const int finite = zero_if_finite(particles.x[i]) == R(0);
    return {i | FirstIndex{}.index * finite};  // without a branch, so that the loop is vectorised
  }
};

}  // namespace malha
