// What goes into a filter and what comes out, by particle.
#pragma once
#include "kernels/particles.h"

namespace malha {

template <class R>
struct FilterEnds {
  Points<R> force;         // N
  Points<R> acceleration;  // m/s^2
  bool adds;               // to what is there

  template <class T>
  KERNEL Vec4<T> take(int particle) const {
    return {T(force.x[particle]), T(force.y[particle]), T(force.z[particle]), T(0)};
  }
  template <class T>
  KERNEL void give(int particle, const Vec4<T>& a) const {
    const Vector3<R> filtered{R(a.x), R(a.y), R(a.z)};
    acceleration.set(particle, adds ? acceleration[particle] + filtered : filtered);
  }
};

/// Four columns of S at once, by unknown: forces of 1 on the unknowns first .. first + 3, one a right-hand side.
struct ColumnEnds {
  int first;
  Vec4<double>* column;
  template <class T>
  KERNEL Vec4<T> take(int unknown) const {
    const int k = unknown - first;
    return {T(k == 0), T(k == 1), T(k == 2), T(k == 3)};
  }
  KERNEL void give(int unknown, const Vec4<double>& a) const { column[unknown] = a; }
};

}  // namespace malha
