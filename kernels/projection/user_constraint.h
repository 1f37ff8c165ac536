// SPDX-License-Identifier: Apache-2.0
// What constraints of the caller's own read and write: particles to a list in double, and their shifts back.
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

template <class R>
KERNEL Vector3<double> exactly(const Points<R>& x, int i) {
  return in_double(x[i]);
}
template <class R>
KERNEL Vector3<double> exactly(const Displaced<R>& p, int i) {
  return p.exact_position(i);
}

/// The places (m) and inverse masses (1/kg) of listed particles.
template <class R, class At>
struct GatherOwn {
  At p;
  const R* w;
  const int* list;
  Vector3<double>* place;
  double* inverse_mass;
  KERNEL void operator()(int k) const {
    place[k] = exactly(p, list[k]);
    inverse_mass[k] = double(w[list[k]]);
  }
};

/// Moves them to other places; none is listed twice. What is held stays, bit by bit.
template <class R>
struct ScatterOwn {
  Displaced<R> p;
  const R* w;
  const int* list;
  const Vector3<double>* place;
  KERNEL void operator()(int k) const {
    const int i = list[k];
    if (w[i] > R(0)) p.d.set(i, rounded<R>(place[k] - in_double(p.x[i])));
  }
};

}  // namespace malha
