// SPDX-License-Identifier: Apache-2.0
// Kinematic particles that follow a rigid motion, and attachments: springs from particles to points that follow one.
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/parallel/compute.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Sets the displacements of pinned particles to their positions at the end of a substep, and their velocities to 0
/// until then.
template <class R>
struct MoveToTarget {
  Particles<R> particles;
  const int* list;
  const Vector3<double>* start;  // m, in the frame of the pose
  Pose end;
  KERNEL void operator()(int k) const {
    const int i = list[k];
    particles.p.d.set(i, rounded<R>(to_world(end, start[k]) - particles.p.exact_start(i)));
    particles.v.set(list[k], {R(0), R(0), R(0)});
  }
};

/// Sets pinned particles to their positions at the end of a substep, with the velocity of their motion.
template <class R>
struct ArriveAtTarget {
  Particles<R> particles;
  const int* list;
  const Vector3<double>*from, *to;  // m, in the frames of the poses; the same array for targets that move rigidly
  Pose before, end;
  double per_dt;  // 1 / h of the substep, 1/s
  KERNEL void operator()(int k) const {
    particles.p.set_start(list[k], to_world(end, to[k]));
    particles.v.set(list[k], rounded<R>((to_world(end, to[k]) - to_world(before, from[k])) * per_dt));
  }
};

/// Pins particles (w = 0) or releases them.
template <class R>
struct SetInverseMass {
  R* w;
  const int* list;
  const R* free;  // 1/kg, of each listed particle; null: 0
  KERNEL void operator()(int k) const { w[list[k]] = free ? free[k] : R(0); }
};

/// Projects attachments: C = p - a, a vector, which is three constraints with constant gradients, so that the spring is
/// exactly linear and rest length 0 needs no special case (XPBD, Macklin et al. 2016; energy |C|^2 / (2 alpha)).
template <class R>
struct SolveAttachment {
  Displaced<R> p;
  const R* w;
  const int* list;
  const Vector3<double>* anchor;  // m, in the frame of the pose
  Pose pose;
  Vector3<R>* lambda;    // null: not accumulated
  R share;               // k' of PBD
  R compliance;          // alpha~ = alpha / dt^2; 0 with PBD
  bool first_iteration;  // first iteration of a substep: lambda is 0
  KERNEL void operator()(int k) const {
    const int i = list[k];
    if (!(w[i] > R(0))) return;
    const Vector3<R> C = rounded<R>(p.exact_position(i) - to_world(pose, anchor[k]));
    const Vector3<R> total = lambda && !first_iteration ? lambda[k] : Vector3<R>{R(0), R(0), R(0)};
    const R per = share / (w[i] + compliance);
    const Vector3<R> change{(-C.x - compliance * total.x) * per, (-C.y - compliance * total.y) * per,
                            (-C.z - compliance * total.z) * per};
    if (lambda) lambda[k] = total + change;
    p.add_displacement(i, change * w[i]);
  }
};

/// Sums |C|^2 of attachments, m^2.
template <class R>
struct MeasureAttachment {
  Points<R> x;
  const int* list;
  const Vector3<double>* anchor;
  Pose pose;
  KERNEL Sum operator()(int k) const {
    const Vector3<R> q = x[list[k]];
    const Vector3<double> C = in_double(q) - to_world(pose, anchor[k]);
    return {dot(C, C)};
  }
};

}  // namespace malha
