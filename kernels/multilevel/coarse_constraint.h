// SPDX-License-Identifier: Apache-2.0
// Coarse constraints: they keep the distance of two particles at most as long as the surface between them, and do not
// shorten it below its restricted value (that of the restricted, predicted positions), so that folds stay as they are.
#pragma once
#include "kernels/constraints/constraint_registry.h"

namespace malha {

/// min(l, |q0 - q1|) <= |p0 - p1| <= l, q the restricted positions. Scenes cannot use it.
struct Coarse : Distance {
  static constexpr const char* name = "coarse";
  static constexpr bool stores_distance = true;  // the restricted distance, in the patch's memory
};

/// Tells whether constraints of these kinds need a number each in the patch's memory.
template <class... Kinds>
constexpr bool stores_distance(KindList<Kinds...>) {
  return (requires { Kinds::stores_distance; } || ...);
}

/// The first sweep stores the restricted distances; the following ones project.
template <class R>
struct ProjectPack<Coarse, Update::Stiff, R> {
  R* least;     // smallest distances, from the batch's first slot on
  R stiffness;  // k'
  bool first_iteration, from_start;

  KERNEL ProjectPack(const SetView<R>& set, int slot, bool first, R /*time*/)
      : least(set.lambda + slot), stiffness(set.stiffness), first_iteration(first), from_start(set.from_start) {}

  template <class S>
  KERNEL void operator()(PatchParticle<S> (&q)[2], const RestOf<S, 1>& rest, int at) const {
    Vector3<S> before = or_zero(rest.valid, q[0].x - q[1].x);
    const Vector3<S> now = before + or_zero(rest.valid, q[0].d - q[1].d);
    if (!from_start) before = now;
    const S length = sqrt(dot(now, now)), &rest_length = rest.value[0];
    if (first_iteration) return store(select(length < rest_length, length, rest_length), least + at);
    S low;
    load(least + at, low);
    const S zero(R(0)), excess = length - max(low, select(length < rest_length, length, rest_length));
    // The direction is that at the start of the substep, as of all constraints
    // (kernels/projection/project_constraint.h).
    const S now_dot_before = dot(now, before);
    const auto small = (now_dot_before > zero) & (abs(excess) * length <= S(R(kMaxStartCorrection)) * now_dot_before);
    const Vector3<S> along = select_vector(small, before, now);
    const S sum = select(small, now_dot_before, length * length) * (q[0].w + q[1].w);
    const auto moves = sum > S(tiny<R>());
    const S part = select(moves, excess * length * S(stiffness) / select(moves, sum, S(R(1))), zero);
    q[0].d = q[0].d - along * (q[0].w * part);
    q[1].d = q[1].d + along * (q[1].w * part);
  }
};

}  // namespace malha
