// SPDX-License-Identifier: Apache-2.0
// Damping that leaves the motion of a body as a whole alone (Müller et al. 2006, section 3.5).
#pragma once
#include "kernels/forces/momenta.h"

namespace malha {

/// The motion of each body as a whole.
template <class R>
struct FindRigidMotion {
  const MeasuredBody* bodies;
  RigidMotion<R>* motions;
  KERNEL void operator()(int b) const {
    const Momenta& now = bodies[b].now;
    motions[b] = RigidMotion<R>(now, now.linear, now.spin.L);
  }
};

/// v += k (v_cm + omega x r - v). Pinned particles keep theirs.
template <class R>
struct DampTowardsRigid {
  using Shared = void;
  Particles<R> particles;
  const ParticleRange* stretches;
  const RigidMotion<R>* motions;  // of each body
  const R* damping;               // of each body: k

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const ParticleRange stretch = stretches[group.index];
    const RigidMotion<R> motion = motions[stretch.body];
    const R k = damping[stretch.body];
    for_each_pack_once<R>(group, stretch.count, [&]<class S>(int n, S) KERNEL_LAMBDA {
      const int i = stretch.first + n;
      S w;
      load(particles.w + i, w);
      const Vector3<S> v = load_points<S>(particles.v, i);
      const Vector3<S> change = (motion.at(load_points<S>(particles.x, i)) - v) * S(k);
      store_points(particles.v, i, v + or_zero(w > S(R(0)), change));
    });
  }
};

}  // namespace malha
