// The rigid part of a body's motion, and damping that leaves it alone (Müller et al. 2006, section 3.5).
#pragma once
#include "kernels/particles.h"

namespace malha {

/// Which particles are meant: item after item from `first` on, or those of a list.
struct Consecutive {
  int first;
  KERNEL int operator[](int item) const { return first + item; }
};
struct Listed {
  const int* list;
  KERNEL int operator[](int item) const { return list[item]; }
};

/// Mass, and the mass-weighted sums of position and velocity. Pinned particles do not count.
struct MassSum {
  double m = 0, x[3] = {}, v[3] = {};
  KERNEL MassSum& operator+=(const MassSum& o) {
    m += o.m;
    for (int k = 0; k < 3; ++k) x[k] += o.x[k], v[k] += o.v[k];
    return *this;
  }
};

template <class R, class Members>
struct SumMass {
  Particles<R> particles;
  Members members;
  KERNEL MassSum operator()(int item) const {
    const int i = members[item];
    const R w = particles.w[i];
    if (!(w > R(0))) return {};
    const double m = 1.0 / w;
    const Vector3<R> x = particles.x[i], v = particles.v[i];
    return {m, {m * x.x, m * x.y, m * x.z}, {m * v.x, m * v.y, m * v.z}};
  }
};

/// Angular momentum L (kg m^2/s) and inertia I (kg m^2: xx, yy, zz, xy, xz, yz) about a point.
struct SpinSum {
  double L[3] = {}, I[6] = {};
  KERNEL SpinSum& operator+=(const SpinSum& o) {
    for (int k = 0; k < 3; ++k) L[k] += o.L[k];
    for (int k = 0; k < 6; ++k) I[k] += o.I[k];
    return *this;
  }
};

template <class R, class Members>
struct SumSpin {
  Particles<R> particles;
  Members members;
  Vector3<double> centre;  // m
  KERNEL SpinSum operator()(int item) const {
    const int i = members[item];
    const R w = particles.w[i];
    if (!(w > R(0))) return {};
    const double m = 1.0 / w;
    const Vector3<R> x = particles.x[i], v = particles.v[i];
    const Vector3<double> r{x.x - centre.x, x.y - centre.y, x.z - centre.z};
    const Vector3<double> L = cross(r, Vector3<double>{v.x * m, v.y * m, v.z * m});
    return {{L.x, L.y, L.z},
            {m * (r.y * r.y + r.z * r.z), m * (r.x * r.x + r.z * r.z), m * (r.x * r.x + r.y * r.y), -m * r.x * r.y,
             -m * r.x * r.z, -m * r.y * r.z}};
  }
};

/// v += k (v_cm + omega x r - v).
template <class R>
struct DampTowardsRigid {
  Particles<R> particles;
  Consecutive members;
  R k;
  Vector3<R> centre, velocity, omega;
  KERNEL void operator()(int item) const {
    const int i = members[item];
    if (!(particles.w[i] > R(0))) return;
    const Vector3<R> v = particles.v[i];
    const Vector3<R> rigid = velocity + cross(omega, particles.x[i] - centre);
    particles.v.set(i, v + (rigid - v) * k);
  }
};

}  // namespace malha
