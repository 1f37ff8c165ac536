// SPDX-License-Identifier: Apache-2.0
// Velocity damping that preserves the rigid motion of each body (Müller et al. 2006, section 3.5).
#pragma once
#include "kernels/forces/momenta.h"

namespace malha {

/// Rigid motion of each body.
template <class R>
struct ComputeRigidMotion {
  const MeasuredBody* bodies;
  RigidMotion<R>* motions;
  KERNEL void operator()(int b) const {
    const Momenta& now = bodies[b].now;
    motions[b] = RigidMotion<R>(now, now.linear, now.spin.L);
  }
};

/// v += k (v_cm + omega x r - v). Pinned particles keep their velocities.
template <class R>
struct DampTowardsRigid {
  using Shared = void;
  Particles<R> particles;
  const ParticleRange* ranges;
  const RigidMotion<R>* motions;  // of each body
  const R* damping;               // of each body: k

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const ParticleRange range = ranges[group.index];
    const RigidMotion<R> motion = motions[range.body];
    const R k = damping[range.body];
    for_each_pack_once<R>(group, range.count, [&]<class S>(int n, S) KERNEL_LAMBDA {
      const int i = range.first + n;
      S w;
      load(particles.w + i, w);
      const Vector3<S> v = load_points<S>(particles.v, i);
      const Vector3<S> change = (motion.at(load_points<S>(particles.x, i)) - v) * S(k);
      store_points(particles.v, i, v + or_zero(w > S(R(0)), change));
    });
  }
};

}  // namespace malha
