// What a coarse constraint does: its particles are no farther apart than the surface between them is long, and are not
// brought closer than they arrived, so that folds stay as they are.
#pragma once
#include "kernels/constraint_registry.h"

namespace malha {

/// min(l, |p0 - p1| on arrival) <= |p0 - p1| <= l. No scene names it.
struct Coarse : Distance {
  static constexpr const char* name = "coarse";
  static constexpr bool remembers = true;  // how far apart particles arrived, in the patch's memory
};

/// Whether constraints of these kinds need a number each there.
template <class... Kinds>
constexpr bool remembers(KindList<Kinds...>) {
  return (requires { Kinds::remembers; } || ...);
}

/// Two sweeps: a fresh one notes how far apart the particles arrived, the next one projects.
template <class R>
struct Correct<Coarse, Update::Stiff, R> {
  R* least;  // from the batch's first slot on
  R number;  // k'
  bool fresh;

  KERNEL Correct(const SetView<R>& set, int slot, bool first)
      : least(set.lambda + slot), number(set.stiffness), fresh(first) {}

  template <class S>
  KERNEL void operator()(Vector3<S> (&q)[2], const S (&w)[2], const RestOf<S, 1>& rest, int at) const {
    const Vector3<S> d = or_zero(rest.held, q[0] - q[1]);
    const S length = root(dot(d, d)), &most = rest.value[0];
    if (fresh) return store(select(length < most, length, most), least + at);
    S low;
    load(least + at, low);
    const S zero(R(0)), sum = length * (w[0] + w[1]);
    const S excess = length - larger(low, select(length < most, length, most));
    const auto moves = sum > S(tiny<R>());
    const S part = select(moves, excess * S(number) / select(moves, sum, S(R(1))), zero);
    q[0] = q[0] - d * (w[0] * part);
    q[1] = q[1] + d * (w[1] * part);
  }
};

}  // namespace malha
