// SPDX-License-Identifier: Apache-2.0
// Excess over maximal lengths.
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

struct Largest {
  double value = 0;
  KERNEL Largest& operator+=(const Largest& o) {
    value = max(value, o.value);
    return *this;
  }
};

/// The excess |p_i - p_j| / longest - 1.
template <class R, class At>
struct MeasureExcess {
  At p;
  const int* ends;   // two a limit
  const R* longest;  // m
  KERNEL Largest operator()(int c) const {
    const Vector3<R> d = p.difference(ends[2 * c], ends[2 * c + 1]);
    return {longest[c] > R(0) ? double(sqrt(dot(d, d)) / longest[c]) - 1 : 0};
  }
};

}  // namespace malha
