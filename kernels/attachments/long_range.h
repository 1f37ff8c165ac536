// SPDX-License-Identifier: Apache-2.0
// Long-range attachments (tethers): C = r - |p - a| >= 0 for a particle p and each pinned particle a that it is
// tethered to, r their geodesic distance at rest times (1 + limit) (Kim, Chentanez, Müller, "Long Range Attachments",
// 2012). Pins do not move, so that a projection moves its own particle alone: one pass over the particles, no
// colouring. Projections one after the other would leave the tether to the farther pin violated by the projection onto
// the nearer: a particle outside both moves to the circle in which the two spheres intersect.
#pragma once
#include "kernels/measure/over_elongation.h"
#include "kernels/projection/direction.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Tethers of each item (a particle) to pins.
template <class R>
struct Tethers {
  const R* w;           // of each particle, 1/kg
  const int* particle;  // of each item
  const int* begin;     // of each item, into anchor and reach; one more at the end
  const int* anchor;    // pins, the farthest first: if two tethers conflict, the nearest pin is projected last
  const R* reach;       // m
  KERNEL bool is_pinned(int k) const { return !(w[anchor[k]] > R(0)); }
};

/// Projects the tethers of each item.
template <class R>
struct LimitTethers {
  Tethers<R> tethers;
  Displaced<R> p;
  KERNEL void operator()(int item) const {
    const int i = tethers.particle[item];
    if (!(tethers.w[i] > R(0))) return;
    const Vector3<R> before = p.d[i];
    Vector3<R> displacement = before;
    int last = tethers.begin[item] - 1;  // the last tether that was projected
    for (int k = tethers.begin[item]; k < tethers.begin[item + 1]; ++k)
      if (project(i, k, displacement)) last = k;
    if (last > tethers.begin[item]) {
      for (int k = last - 1; k >= tethers.begin[item]; --k)
        if (is_beyond(i, k, displacement)) displacement = onto_both(i, displacement, last, k);
      for (int k = last + 1; k < tethers.begin[item + 1]; ++k) project(i, k, displacement);
    }
    if (!same(displacement, before)) p.d.set(i, displacement);
  }

 private:
  /// Vector from the pin to the particle where the substep began; after(): with this displacement of the particle.
  KERNEL Vector3<R> at_start(int i, int k) const { return p.start_difference(i, tethers.anchor[k]); }
  KERNEL Vector3<R> after(int i, int k, const Vector3<R>& displacement) const {
    return at_start(i, k) + (displacement - p.d[tethers.anchor[k]]);
  }

  KERNEL bool is_beyond(int i, int k, const Vector3<R>& displacement) const {
    if (!tethers.is_pinned(k)) return false;  // the pin was released
    const Vector3<R> d = after(i, k, displacement);
    return dot(d, d) > tethers.reach[k] * tethers.reach[k];
  }

  /// Projects a particle beyond a tether's length onto its sphere: along the direction at the start of the substep, as
  /// all constraints (kernels/projection/direction.h), where the correction is small beside the length. Returns true if
  /// it was beyond.
  KERNEL bool project(int i, int k, Vector3<R>& displacement) const {
    if (!is_beyond(i, k, displacement)) return false;
    const Vector3<R> d = after(i, k, displacement), start = at_start(i, k);
    const R r = tethers.reach[k], d2 = dot(d, d), cross = dot(d, start), start2 = dot(start, start);
    const R per = start2 > R(0) ? R(1) / sqrt(start2) : R(0), along = cross * per;
    const Vector3<R> perpendicular = d - start * (per * along);
    const R half_chord2 = r * r - dot(perpendicular, perpendicular);  // by a right triangle
    if (cross > R(0) && half_chord2 > R(0) && along - sqrt(half_chord2) <= R(kMaxStartCorrection) * r)
      displacement = displacement - start * (per * (along - sqrt(half_chord2)));
    else
      displacement = displacement + d * (r / sqrt(d2) - R(1));
    return true;
  }

  /// The displacement to the closest point of the intersection of the spheres around two pins; if they do not
  /// intersect, to the point of the nearer pin's sphere that is closest to the other pin.
  KERNEL Vector3<R> onto_both(int i, const Vector3<R>& displacement, int nearer, int other) const {
    const Vector3<R> from = after(i, nearer, displacement),
                     between = p.difference(tethers.anchor[other], tethers.anchor[nearer]);
    const R D2 = dot(between, between), D = sqrt(D2), r = tethers.reach[nearer];
    if (!(D > tiny<R>())) return displacement;
    const Vector3<R> axis = between * (R(1) / D);
    const R along = (D2 + r * r - tethers.reach[other] * tethers.reach[other]) / (R(2) * D),
            rho2 = r * r - along * along;
    if (!(along < r)) return displacement + (axis * r - from);
    const Vector3<R> away = from - axis * dot(from, axis);
    const R away2 = dot(away, away);
    if (!(rho2 > R(0)) || !(away2 > tiny<R>())) return displacement;  // one inside the other, or no unique direction
    return displacement + (axis * along + away * sqrt(rho2 / away2) - from);
  }
};

/// Largest relative excess of an item over the lengths of its tethers; 0 if it is within all.
template <class R>
struct MeasureTetherExcess {
  Tethers<R> tethers;
  Points<R> x;
  KERNEL Largest operator()(int item) const {
    Largest most;
    const int i = tethers.particle[item];
    if (!(tethers.w[i] > R(0))) return most;
    for (int k = tethers.begin[item]; k < tethers.begin[item + 1]; ++k) {
      if (!tethers.is_pinned(k) || !(tethers.reach[k] > R(0))) continue;
      const Vector3<R> d = x.difference(tethers.anchor[k], i);
      most += {double(sqrt(dot(d, d)) / tethers.reach[k]) - 1};
    }
    return most;
  }
};

}  // namespace malha
