// SPDX-License-Identifier: Apache-2.0
// Final guard of a substep between deformable bodies and edges of the environment: displacements are truncated at
// division planes so that no pair of primitives intersects (kernels/self_collision/truncate.h).
#pragma once
#include "kernels/environment/edge_contact_solve.h"

namespace malha {

/// Copies points between layouts.
template <class R, class From = Points<R>, class To = ScatteredPoints<R>>
struct CopyPoints {
  From from;
  To to;
  KERNEL void operator()(int i) const { to.set(i, from[i]); }
};

/// Division planes of contacts: tests whether their sides are separated at the end of the motion.
template <class R>
struct DivisionPlanes {
  ScatteredPoints<R> x0, moved;
  R least;  // m: lower bound of the gap that truncation leaves

  /// Coordinate of particle j at x0 along n.
  KERNEL R at_start(const EdgeContact<R>& c, int j) const { return dot(c.n, x0[c.i[j]] - x0[c.i[0]]); }
  /// The gap that the contact must keep.
  KERNEL R required_gap(const EdgeContact<R>& c) const { return malha::required_gap(c.gap, least); }
  KERNEL bool are_separated(const EdgeContact<R>& c) const {
    ContactSides<R> sides;
    for (int j = 0; j < 4; ++j) sides.add(j, c.first, at_start(c, j) + dot(c.n, moved[c.i[j]]));
    return !(sides.low - sides.high < required_gap(c));
  }
};

/// Marks the contacts whose sides would intersect; counts those that truncation can still resolve.
template <class R>
struct FindEdgeViolations {
  DivisionPlanes<R> planes;
  const EdgeContact<R>* contacts;
  const unsigned char* truncated;
  const R* w;
  unsigned char* violating;
  KERNEL Sum operator()(int k) const {
    const EdgeContact<R>& c = contacts[k];
    violating[k] = 0;
    if (planes.are_separated(c)) return {};
    violating[k] = 1;
    for (int j = 0; j < 4; ++j)
      if (w[c.i[j]] > R(0) && !truncated[c.i[j]]) return {1.0};
    return {};
  }
};

/// Tells whether a particle that can still move is of a violating contact.
template <class R>
KERNEL bool can_end_violation(int i, const Keyed* ends, const int* begin, const unsigned char* violating, const R* w,
                              const unsigned char* truncated) {
  if (truncated[i] || !(w[i] > R(0))) return false;
  for (int e = begin[i]; e < begin[i + 1]; ++e)
    if (violating[ends[e].value / 4]) return true;
  return false;
}

/// Truncates the displacement of every particle of a violating contact so that it alone cannot make any of its contacts
/// intersect; or, if `to_rest`, to zero: particles at rest cannot intersect each other.
template <class R, class SetPosition>
struct TruncateParticles {
  DivisionPlanes<R> planes;
  SetPosition set_position;
  bool to_rest;
  const EdgeContact<R>* contacts;
  const Keyed* ends;
  const int* begin;
  const unsigned char* violating;
  const R* w;
  unsigned char* truncated;
  KERNEL void operator()(int i) const {
    if (!can_end_violation(i, ends, begin, violating, w, truncated)) return;
    const Vector3<R> d = planes.moved[i];
    R fraction = to_rest ? R(0) : R(1);
    for (int e = begin[i]; e < begin[i + 1] && !to_rest; ++e) {
      const EdgeContact<R>& c = contacts[ends[e].value / 4];
      const int own = ends[e].value % 4;
      ContactSides<R> sides;
      for (int j = 0; j < 4; ++j) sides.add(j, c.first, planes.at_start(c, j));
      // Each side may close half of the excess gap, and particles behind their side's plane may come up to it.
      const R at = planes.at_start(c, own), half = R(0.499) * (c.gap - planes.required_gap(c));
      const R allowed = own < c.first ? at - sides.low + half : sides.high - at + half;
      const R nearing = own < c.first ? -dot(c.n, d) : dot(c.n, d);
      if (nearing > allowed) fraction = min(fraction, allowed > R(0) ? allowed / nearing : R(0));
    }
    const Vector3<R> to = planes.x0[i] + d * fraction;
    set_position(i, to);
    planes.moved.set(i, to - planes.x0[i]);
    truncated[i] = 1;
  }
};

}  // namespace malha
