// SPDX-License-Identifier: Apache-2.0
// Final guard of a substep between deformable bodies and edges of the environment: no pair of primitives intersects. By
// planes, as kernels/self_collision/truncate.h says.
#pragma once
#include "kernels/environment/edge_contact_solve.h"

namespace malha {

/// A free particle stays where the substep began.
template <class R>
struct StandStill {
  Particles<R> particles;
  KERNEL void operator()(int i) const {
    if (particles.w[i] > R(0)) particles.p.clear_displacement(i);
  }
};

/// A particle that a mesh lifted from x0 to x before the substep, and that was then held where it goes to: as much of
/// the lift as was undone is no motion.
template <class R>
struct ForgetLift {
  Particles<R> particles;
  ScatteredPoints<R> x0;
  Vector3<R> origin;  // m, of x0
  KERNEL void operator()(int i) const {
    const Displaced<R>& p = particles.p;
    const Vector3<R> from = x0[i], lift = p.start_relative_to(i, from, origin);
    const R squared = dot(lift, lift);
    if (!(particles.w[i] > R(0)) || !(squared > R(0)) || !(squared < R(INFINITY))) return;
    const Vector3<R> way = p.displacement_from(i, from, origin);
    const R kept = min(max(dot(lift, way) / squared, R(0)), R(1));
    if (!(kept < R(1))) return;
    p.set_start(i, in_double(origin) + in_double(from) + in_double(lift * kept));
    p.set_displacement_from(i, from, origin, way);
  }
};

template <class R, class From = Points<R>, class To = ScatteredPoints<R>>
struct CopyPoints {
  From from;
  To to;
  KERNEL void operator()(int i) const { to.set(i, from[i]); }
};

template <class R>
struct DivisionPlanes {
  ScatteredPoints<R> x0, moved;
  R least;  // m: no gap closes further

  /// Of particle j at x0, along n.
  KERNEL R at_start(const SelfContact<R>& c, int j) const { return dot(c.n, x0[c.i[j]] - x0[c.i[0]]); }
  /// Which the gap must keep.
  KERNEL R kept(const SelfContact<R>& c) const { return kept_of(c.gap, least); }
  KERNEL bool apart(const SelfContact<R>& c) const {
    ContactSides<R> sides;
    for (int j = 0; j < 4; ++j) sides.add(j, c.first, at_start(c, j) + dot(c.n, moved[c.i[j]]));
    return !(sides.low - sides.high < kept(c));
  }
};

/// Marks the pairs that are about to cross; counts those that holding back can still help.
template <class R>
struct FindCrossing {
  DivisionPlanes<R> planes;
  const SelfContact<R>* contacts;
  const unsigned char* held;
  const R* w;
  unsigned char* crossing;
  KERNEL Sum operator()(int k) const {
    const SelfContact<R>& c = contacts[k];
    crossing[k] = 0;
    if (planes.apart(c)) return {};
    crossing[k] = 1;
    for (int j = 0; j < 4; ++j)
      if (w[c.i[j]] > R(0) && !held[c.i[j]]) return {1.0};
    return {};
  }
};

/// Of a crossing pair every particle goes only as far as none of its contacts can be broken by it; or, if it `rests`,
/// nowhere: of those that rest none can cross another.
template <class R, class Place>
struct HoldParticles {
  DivisionPlanes<R> planes;
  Place place;
  bool rests;
  const SelfContact<R>* contacts;
  const Keyed* ends;
  const int* begin;
  const unsigned char* crossing;
  const R* w;
  unsigned char* held;
  KERNEL void operator()(int i) const {
    if (held[i] || !(w[i] > R(0))) return;
    bool crosses = false;
    for (int e = begin[i]; e < begin[i + 1] && !crosses; ++e) crosses = crossing[ends[e].value / 4];
    if (!crosses) return;
    const Vector3<R> d = planes.moved[i];
    R part = rests ? R(0) : R(1);
    for (int e = begin[i]; e < begin[i + 1] && !rests; ++e) {
      const SelfContact<R>& c = contacts[ends[e].value / 4];
      const int own = ends[e].value % 4;
      ContactSides<R> sides;
      for (int j = 0; j < 4; ++j) sides.add(j, c.first, planes.at_start(c, j));
      // Half of what the gap may lose is each side's, and what lies behind its plane may come up to it.
      const R at = planes.at_start(c, own), half = R(0.499) * (c.gap - planes.kept(c));
      const R room = own < c.first ? at - sides.low + half : sides.high - at + half;
      const R nearing = own < c.first ? -dot(c.n, d) : dot(c.n, d);
      if (nearing > room) part = min(part, room > R(0) ? room / nearing : R(0));
    }
    const Vector3<R> to = planes.x0[i] + d * part;
    place(i, to);
    planes.moved.set(i, to - planes.x0[i]);
    held[i] = 1;
  }
};

}  // namespace malha
