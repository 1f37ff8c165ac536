// SPDX-License-Identifier: Apache-2.0
// Mean motion of particles in a substep, as a reduction.
#pragma once
#include "kernels/parallel/compute.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Weighted mean of motions.
struct MeanMotion {
  double sum[3] = {}, weight = 0;
  KERNEL MeanMotion& operator+=(const MeanMotion& o) {
    for (int k = 0; k < 3; ++k) sum[k] += o.sum[k];
    weight += o.weight;
    return *this;
  }
  /// The mean; 0 without any motion.
  KERNEL Vector3<double> value() const {
    const double per = weight > 0 ? 1 / weight : 0;
    return {sum[0] * per, sum[1] * per, sum[2] * per};
  }
};

/// Sums the finite motions of particles that take part.
template <class R>
struct SumMotion {
  ScatteredPoints<R> moved;
  const unsigned char* takes_part;
  KERNEL MeanMotion operator()(int i) const {
    const Vector3<R> d = moved[i];
    if (!takes_part[i] || !((d.x + d.y + d.z) * R(0) == R(0))) return {};
    return {{double(d.x), double(d.y), double(d.z)}, 1.0};
  }
};

}  // namespace malha
