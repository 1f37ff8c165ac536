// SPDX-License-Identifier: Apache-2.0
// Gather and scatter for user constraints: positions of listed particles in double, and their new positions.
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

template <class R>
KERNEL Vector3<double> exact_position(const Points<R>& x, int i) {
  return in_double(x[i]);
}
template <class R>
KERNEL Vector3<double> exact_position(const Displaced<R>& p, int i) {
  return p.exact_position(i);
}

/// Gathers positions (m) and inverse masses (1/kg) of listed particles.
template <class R, class At>
struct GatherUserParticles {
  At p;
  const R* w;
  const int* list;
  Vector3<double>* position;
  double* inverse_mass;
  KERNEL void operator()(int k) const {
    position[k] = exact_position(p, list[k]);
    inverse_mass[k] = double(w[list[k]]);
  }
};

/// Moves listed particles to other positions; none is listed twice. Pinned particles keep their bits.
template <class R>
struct ScatterUserParticles {
  Displaced<R> p;
  const R* w;
  const int* list;
  const Vector3<double>* position;
  KERNEL void operator()(int k) const {
    const int i = list[k];
    if (w[i] > R(0)) p.d.set(i, rounded<R>(position[k] - in_double(p.x[i])));
  }
};

}  // namespace malha
