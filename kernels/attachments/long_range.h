// SPDX-License-Identifier: Apache-2.0
// long_range: C = r - |p - a| >= 0 for a particle p and each pinned particle a that it hangs on, r their distance over
// the surface at rest times (1 + limit) (Kim, Chentanez, Müller, "Long Range Attachments", 2012). Pins do not give way,
// so that a projection moves its own particle alone: one pass over the particles, no colouring. One projection after
// the other would leave the farther pin's reach exceeded by what the nearest then takes back: a particle outside both
// goes to the circle in which the two spheres meet.
#pragma once
#include "kernels/measure/over_elongation.h"
#include "kernels/projection/direction.h"
#include "kernels/simd/particles.h"

namespace malha {

/// The pins that each item hangs on.
template <class R>
struct PinReaches {
  const R* w;           // of each particle, 1/kg
  const int* particle;  // of each item
  const int* begin;     // into anchor and reach, per item, one more at the end
  const int* anchor;    // the farthest first: where two contradict each other, the nearest has the last word
  const R* reach;       // m
  KERNEL bool holds(int k) const { return !(w[anchor[k]] > R(0)); }
};

template <class R>
struct LimitReach {
  PinReaches<R> of;
  Displaced<R> p;
  KERNEL void operator()(int item) const {
    const int i = of.particle[item];
    if (!(of.w[i] > R(0))) return;
    const Vector3<R> before = p.d[i];
    Vector3<R> way = before;
    int last = of.begin[item] - 1;  // that held it
    for (int k = of.begin[item]; k < of.begin[item + 1]; ++k)
      if (pull(i, k, way)) last = k;
    if (last > of.begin[item]) {
      for (int k = last - 1; k >= of.begin[item]; --k)
        if (is_beyond(i, k, way)) way = where_both_end(i, way, last, k);
      for (int k = last + 1; k < of.begin[item + 1]; ++k) pull(i, k, way);
    }
    if (!same(way, before)) p.d.set(i, way);
  }

 private:
  /// From the pin to the particle, where the substep began; and when it has gone so far.
  KERNEL Vector3<R> at_start(int i, int k) const { return p.start_difference(i, of.anchor[k]); }
  KERNEL Vector3<R> after(int i, int k, const Vector3<R>& way) const {
    return at_start(i, k) + (way - p.d[of.anchor[k]]);
  }

  KERNEL bool is_beyond(int i, int k, const Vector3<R>& way) const {
    if (!of.holds(k)) return false;  // no pin any more
    const Vector3<R> d = after(i, k, way);
    return dot(d, d) > of.reach[k] * of.reach[k];
  }

  /// To its reach, if it is beyond: along the way to the pin where the substep began, as all constraints
  /// (kernels/projection/direction.h), where that is small beside its reach.
  KERNEL bool pull(int i, int k, Vector3<R>& way) const {
    if (!is_beyond(i, k, way)) return false;
    const Vector3<R> d = after(i, k, way), start = at_start(i, k);
    const R r = of.reach[k], d2 = dot(d, d), cross = dot(d, start), start2 = dot(start, start);
    const R per = start2 > R(0) ? R(1) / sqrt(start2) : R(0), along = cross * per;
    const Vector3<R> aside = d - start * (per * along);
    const R room = r * r - dot(aside, aside);  // of a right triangle
    if (cross > R(0) && room > R(0) && along - sqrt(room) <= R(kMaxStartCorrection) * r)
      way = way - start * (per * (along - sqrt(room)));
    else
      way = way + d * (r / sqrt(d2) - R(1));
    return true;
  }

  /// The point of the spheres around two pins that is nearest; where they do not meet, the point of the nearer pin's
  /// that is nearest to the other.
  KERNEL Vector3<R> where_both_end(int i, const Vector3<R>& way, int nearer, int other) const {
    const Vector3<R> from = after(i, nearer, way), between = p.difference(of.anchor[other], of.anchor[nearer]);
    const R D2 = dot(between, between), D = sqrt(D2), r = of.reach[nearer];
    if (!(D > tiny<R>())) return way;
    const Vector3<R> axis = between * (R(1) / D);
    const R along = (D2 + r * r - of.reach[other] * of.reach[other]) / (R(2) * D), rho2 = r * r - along * along;
    if (!(along < r)) return way + (axis * r - from);
    const Vector3<R> away = from - axis * dot(from, axis);
    const R away2 = dot(away, away);
    if (!(rho2 > R(0)) || !(away2 > tiny<R>())) return way;  // one inside the other, or no direction
    return way + (axis * along + away * sqrt(rho2 / away2) - from);
  }
};

/// How far the particle of an item is beyond the reach of a pin, over that reach; 0 where it is within all.
template <class R>
struct MeasureBeyondReach {
  PinReaches<R> of;
  Points<R> x;
  KERNEL Largest operator()(int item) const {
    Largest most;
    const int i = of.particle[item];
    if (!(of.w[i] > R(0))) return most;
    for (int k = of.begin[item]; k < of.begin[item + 1]; ++k) {
      if (!of.holds(k) || !(of.reach[k] > R(0))) continue;
      const Vector3<R> d = x.difference(of.anchor[k], i);
      most += {double(sqrt(dot(d, d)) / of.reach[k]) - 1};
    }
    return most;
  }
};

}  // namespace malha
