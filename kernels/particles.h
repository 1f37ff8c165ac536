// Views of the particles: one array a coordinate, so that neighbours are read and written many at a time.
#pragma once
#include "kernels/vec.h"

namespace malha {

/// Points or vectors, as three arrays.
template <class R>
struct Points {
  R *x = nullptr, *y = nullptr, *z = nullptr;
  KERNEL Vector3<R> operator[](int i) const { return {x[i], y[i], z[i]}; }
  KERNEL void set(int i, const Vector3<R>& a) const { x[i] = a.x, y[i] = a.y, z[i] = a.z; }
};

/// The same, four numbers a point: for those that are read here and there. Setting one leaves its w.
template <class R>
struct ScatteredPoints {
  Vec4<R>* of = nullptr;
  KERNEL Vector3<R> operator[](int i) const { return of[i].xyz(); }
  KERNEL void set(int i, const Vector3<R>& a) const { of[i].set(a); }
};

template <class R>
struct Particles {
  int count;
  Points<R> x;  // position at the start of the substep, m
  Points<R> v;  // velocity, m/s
  Points<R> p;  // predicted position, m
  const R* w;   // 1 / m, 1/kg, 0 where pinned
};

}  // namespace malha
