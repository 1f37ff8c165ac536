// SPDX-License-Identifier: Apache-2.0
// Places at which closed seams hold several particles. What moves these one by one after the patches' solves, such as
// contacts, opens the seams; here the particles of a place come together again, at their centre of mass.
#pragma once
#include "kernels/parallel/compute.h"
#include "kernels/simd/particles.h"

namespace malha {

template <class R>
struct CloseSeams {
  Displaced<R> p;
  const R* w;        // of each particle
  const int* begin;  // of each place, one more at the end
  const int* list;   // particles
  KERNEL void operator()(int place) const {
    const int first = begin[place], end = begin[place + 1], origin = list[first];
    // Relative to the first particle: to the centre of mass, or to the first one that is pinned.
    double mass = 0, sum[3] = {};
    for (int k = first; k < end; ++k) {
      const Vector3<double> offset = in_double(p.difference(list[k], origin));
      const bool is_pinned = !(w[list[k]] > R(0));
      const double m = is_pinned ? 1 : 1 / double(w[list[k]]);
      if (is_pinned) mass = sum[0] = sum[1] = sum[2] = 0;
      mass += m, sum[0] += m * offset.x, sum[1] += m * offset.y, sum[2] += m * offset.z;
      if (is_pinned) break;
    }
    const Vector3<double> centre = Vector3<double>{sum[0], sum[1], sum[2]} * (1 / mass);
    // The first particle moves last, because the others are relative to it.
    for (int k = end - 1; k >= first; --k) {
      const int i = list[k];
      if (w[i] > R(0)) p.add_displacement(i, rounded<R>(centre - in_double(p.difference(i, origin))));
    }
  }
};

}  // namespace malha
