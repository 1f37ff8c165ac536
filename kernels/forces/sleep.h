// SPDX-License-Identifier: Apache-2.0
// Speed and bounds reductions for sleeping; zeroes velocities.
#pragma once
#include "kernels/measure/over_elongation.h"

namespace malha {

/// Squared speeds of movable particles, m^2/s^2.
template <class R>
struct MeasureSpeed {
  Particles<R> particles;
  KERNEL Largest operator()(int i) const {
    const Vector3<R> v = particles.v[i];
    return {particles.w[i] > R(0) ? double(dot(v, v)) : 0};
  }
};

/// v = 0; x keeps its bits.
template <class R>
struct ClearVelocity {
  Points<R> v;
  KERNEL void operator()(int i) const { v.set(i, {R(0), R(0), R(0)}); }
};

/// Axis-aligned bounding box of all particles.
struct Bounds {
  double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
  KERNEL Bounds& operator+=(const Bounds& o) {
    for (int k = 0; k < 3; ++k) {
      lower[k] = min(o.lower[k], lower[k]);
      upper[k] = max(upper[k], o.upper[k]);
    }
    return *this;
  }
};

template <class R>
struct MeasureBounds {
  Points<R> x;
  KERNEL Bounds operator()(int i) const {
    const Vector3<R> a = x[i];
    return {{double(a.x), double(a.y), double(a.z)}, {double(a.x), double(a.y), double(a.z)}};
  }
};

}  // namespace malha
