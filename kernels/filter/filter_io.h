// SPDX-License-Identifier: Apache-2.0
// Input and output of a filter, by particle.
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

/// Forces in, accelerations out.
template <class R>
struct FilterIo {
  Points<R> force;         // N
  Points<R> acceleration;  // m/s^2
  bool adds;               // adds to the accelerations instead of storing them

  template <class T>
  KERNEL Vec4<T> load_rhs(int particle) const {
    return {T(force.x[particle]), T(force.y[particle]), T(force.z[particle]), T(0)};
  }
  template <class T>
  KERNEL void store_solution(int particle, const Vec4<T>& a) const {
    const Vector3<R> filtered{R(a.x), R(a.y), R(a.z)};
    acceleration.set(particle, adds ? acceleration[particle] + filtered : filtered);
  }
};

/// Sets forces and accelerations to 0, for particles outside of the filter too.
template <class R>
struct ClearFilterIo {
  FilterIo<R> io;
  KERNEL void operator()(int particle) const {
    const Vector3<R> none{R(0), R(0), R(0)};
    io.force.set(particle, none), io.acceleration.set(particle, none);
  }
};

/// Input and output for four columns of S at once, by unknown: unit forces on the unknowns first .. first + 3, one per
/// right-hand side. On a free body without their mean, whose response would cancel the digits of the rest.
struct ColumnIo {
  int first;
  const double* mass;  // kg, of each unknown
  double per_mass;     // 1/kg, of a free body, otherwise 0
  Vec4<double>* column;
  template <class T>
  KERNEL Vec4<T> load_rhs(int unknown) const {
    const int k = unknown - first;
    const double mean = mass[unknown] * per_mass;
    return {T((k == 0) - mean), T((k == 1) - mean), T((k == 2) - mean), T((k == 3) - mean)};
  }
  KERNEL void store_solution(int unknown, const Vec4<double>& a) const { column[unknown] = a; }
};

}  // namespace malha
