// The particle passes of a PBD step: external forces, prediction, and the new state (Müller et al. 2006, section 3.1).
#pragma once
#include "kernels/particles.h"

namespace malha {

/// v += dt g; p = x + dt v. Pinned particles stay.
template <class R>
struct Predict {
  Particles<R> particles;
  R dt;
  Vector3<R> gravity;  // m/s^2
  KERNEL void operator()(int i) const {
    Vec4<R>& v = particles.v[i];
    Vec4<R>& p = particles.p[i];
    if (p.w > R(0)) v.set(v.xyz() + gravity * dt);
    p.set(particles.x[i].xyz() + v.xyz() * dt);
  }
};

/// Viscous drag towards the wind, b (u - v), implicit in v so that it is stable for any b: v = (v + h u) / (1 + h),
/// h = dt w b.
template <class R>
struct Drag {
  Particles<R> particles;
  R dt, drag;       // s, N s/m
  Vector3<R> wind;  // u, m/s
  KERNEL void operator()(int i) const {
    Vec4<R>& v = particles.v[i];
    const R h = dt * drag * particles.p[i].w;
    v.set((v.xyz() + wind * h) * (R(1) / (R(1) + h)));
  }
};

/// The lowest index with a property; none: beyond every index.
struct FirstIndex {
  int index = 0x7fffffff;
  KERNEL FirstIndex& operator+=(const FirstIndex& other) {
    if (other.index < index) index = other.index;
    return *this;
  }
};

/// v = (p - x) / dt; x = p. Returns the particle if it is no longer finite. Written as the predicted velocity and what
/// the constraints changed of it: p - x is rounded to the spacing of the coordinates, and over a short dt that would
/// outweigh gravity (in float and 160 substeps a particle 2 m up would hang still).
template <class R>
struct UpdateState {
  Particles<R> particles;
  R dt, per_dt;  // s, 1/s
  KERNEL FirstIndex operator()(int i) const {
    const Vector3<R> p = particles.p[i].xyz();
    const Vector3<R> v = particles.v[i].xyz();
    particles.v[i].set(v + (p - (particles.x[i].xyz() + v * dt)) * per_dt);
    particles.x[i].set(p);
    const R zero = (p.x + p.y + p.z) * R(0);  // NaN unless every term is finite
    return zero == R(0) ? FirstIndex{} : FirstIndex{i};
  }
};

}  // namespace malha
