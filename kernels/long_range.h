// long_range: C = r - |p - a| >= 0 for a particle p and each pinned particle a that it hangs on, r their distance over
// the surface at rest times (1 + limit) (Kim, Chentanez, Müller, "Long Range Attachments", 2012). Pins do not give way,
// so that a projection moves its own particle alone: one pass over the particles, no colouring. One projection after
// the other would leave the farther pin's reach exceeded by what the nearest then takes back: a particle outside both
// goes to the circle in which the two spheres meet.
#pragma once
#include "kernels/limits.h"
#include "kernels/particles.h"

namespace malha {

template <class R>
struct LimitReach {
  Points<R> p;
  const R* w;           // of each particle, 1/kg
  const int* particle;  // of each item
  const int* begin;     // into anchor and reach, per item, one more at the end
  const int* anchor;    // the farthest first: where two contradict each other, the nearest has the last word
  const R* reach;       // m
  KERNEL void operator()(int item) const {
    const int i = particle[item];
    if (!(w[i] > R(0))) return;
    Vector3<R> at = p[i];
    int last = begin[item] - 1;  // that held it
    for (int k = begin[item]; k < begin[item + 1]; ++k)
      if (pull(k, at)) last = k;
    if (last <= begin[item]) return p.set(i, at);
    for (int k = last - 1; k >= begin[item]; --k)
      if (is_beyond(k, at)) at = where_both_end(at, last, k);
    for (int k = last + 1; k < begin[item + 1]; ++k) pull(k, at);
    p.set(i, at);
  }

  KERNEL bool is_beyond(int k, const Vector3<R>& at) const {
    if (w[anchor[k]] > R(0)) return false;  // no pin any more
    const Vector3<R> d = p[anchor[k]] - at;
    return dot(d, d) > reach[k] * reach[k];
  }

  /// To its reach, if it is beyond.
  KERNEL bool pull(int k, Vector3<R>& at) const {
    if (!is_beyond(k, at)) return false;
    const Vector3<R> d = p[anchor[k]] - at;
    at = at + d * (R(1) - reach[k] / root(dot(d, d)));
    return true;
  }

  /// The point of the spheres around two pins that is nearest to `at`; where they do not meet, the point of the nearer
  /// pin's that is nearest to the other.
  KERNEL Vector3<R> where_both_end(const Vector3<R>& at, int nearer, int other) const {
    const Vector3<R> a = p[anchor[nearer]], between = p[anchor[other]] - a;
    const R D2 = dot(between, between), D = root(D2), r = reach[nearer];
    if (!(D > tiny<R>())) return at;
    const Vector3<R> axis = between * (R(1) / D), from = at - a;
    const R along = (D2 + r * r - reach[other] * reach[other]) / (R(2) * D), rho2 = r * r - along * along;
    if (!(along < r)) return a + axis * r;
    const Vector3<R> away = from - axis * dot(from, axis);
    const R away2 = dot(away, away);
    if (!(rho2 > R(0)) || !(away2 > tiny<R>())) return at;  // one inside the other, or no direction
    return a + axis * along + away * root(rho2 / away2);
  }
};

/// How far the particle of an item is beyond the reach of a pin, over that reach; 0 where it is within all.
template <class R>
struct MeasureBeyondReach {
  LimitReach<R> limits;
  KERNEL Largest operator()(int item) const {
    Largest most;
    if (!(limits.w[limits.particle[item]] > R(0))) return most;
    for (int k = limits.begin[item]; k < limits.begin[item + 1]; ++k) {
      if (limits.w[limits.anchor[k]] > R(0) || !(limits.reach[k] > R(0))) continue;
      const Vector3<R> d = limits.p[limits.anchor[k]] - limits.p[limits.particle[item]];
      most += {double(root(dot(d, d)) / limits.reach[k]) - 1};
    }
    return most;
  }
};

}  // namespace malha
