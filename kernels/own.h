// What constraints of the caller's own read and write: particles to a list in double, and their shifts back.
#pragma once
#include "kernels/particles.h"

namespace malha {

/// The places (m) and inverse masses (1/kg) of listed particles.
template <class R>
struct GatherOwn {
  Points<R> p;
  const R* w;
  const int* list;
  Vector3<double>* place;
  double* inverse_mass;
  KERNEL void operator()(int k) const {
    place[k] = in_double(p[list[k]]);
    inverse_mass[k] = double(w[list[k]]);
  }
};

/// Moves them to other places; none is listed twice. What is held stays, bit by bit.
template <class R>
struct ScatterOwn {
  Points<R> p;
  const R* w;
  const int* list;
  const Vector3<double>* place;
  KERNEL void operator()(int k) const {
    if (w[list[k]] > R(0)) p.set(list[k], rounded<R>(place[k]));
  }
};

}  // namespace malha
