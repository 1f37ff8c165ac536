// SPDX-License-Identifier: Apache-2.0
// Kinetic and potential energy, which the energy guard sums during a run.
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

struct MotionEnergy {
  double kinetic = 0, potential = 0;  // J; gravity's, 0 at the origin
  KERNEL MotionEnergy& operator+=(const MotionEnergy& o) {
    kinetic += o.kinetic, potential += o.potential;
    return *this;
  }
};

/// Energy of the movable particles, in double, because squares of large floats overflow.
template <class R>
struct MeasureMotionEnergy {
  Particles<R> particles;
  Vector3<double> gravity;  // m/s^2
  KERNEL MotionEnergy operator()(int i) const {
    const R w = particles.w[i];
    if (!(w > R(0))) return {};
    const double m = 1.0 / double(w);
    const Vector3<double> x = in_double(particles.x[i]), v = in_double(particles.v[i]);
    return {m / 2 * dot(v, v), -m * dot(gravity, x)};
  }
};

/// Particles first .. first + count - 1, all of one group.
struct ParticleRun {
  int first, count, group;
};

/// Energy of each run, for many bodies in one launch.
template <class R>
struct MeasureRuns {
  MeasureMotionEnergy<R> of;
  const ParticleRun* runs;
  MotionEnergy* sums;
  KERNEL void operator()(int r) const {
    MotionEnergy sum;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) sum += of(i);
    sums[r] = sum;
  }
};

}  // namespace malha
