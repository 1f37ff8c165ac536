// What takes from the filtered accelerations of a free body that which internal forces cannot do.
#pragma once
#include "kernels/damping.h"

namespace malha {

/// a -= mean + alpha x r, r from the centre of mass: no net force, and no torque where I alpha is the torque.
template <class R>
struct RemoveRigid {
  Particles<R> particles;  // x at the start of the substep
  Points<R> acceleration;
  Listed members;
  Vector3<R> centre, mean, alpha;  // m, m/s^2, 1/s^2
  KERNEL void operator()(int item) const {
    const int i = members[item];
    const Vector3<R> r = particles.x[i] - centre;
    acceleration.set(i, acceleration[i] - mean - cross(alpha, r));
  }
};

/// The published correction (Desbrun, Schröder, Barr 1999, section 3.3): a += (x_G - x) x T / m. It has not the
/// dimension of an acceleration and over-corrects; for comparison.
template <class R>
struct RemoveAsPublished {
  Particles<R> particles;
  Points<R> acceleration;
  Listed members;
  Vector3<R> centre, mean, torque;  // m, m/s^2, N m
  KERNEL void operator()(int item) const {
    const int i = members[item];
    const Vector3<R> r = particles.x[i] - centre;
    acceleration.set(i, acceleration[i] - mean - cross(r, torque) * particles.w[i]);
  }
};

}  // namespace malha
