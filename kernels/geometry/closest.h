// SPDX-License-Identifier: Apache-2.0
// Closest points of a point and a triangle, and of two segments, as weights of their ends. Everything is computed from
// differences of positions. Degenerate triangles and segments (no area, no length) are segments and points.
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

template <class R>
KERNEL R clamped(R t) {
  const R least = t > R(0) ? t : R(0);
  return least < R(1) ? least : R(1);  // without a branch, which nothing would predict
}

/// Where on the segment of direction d from the origin lies the point closest to p: 0 at its start, 1 at its end.
template <class R>
KERNEL R closest_on_segment(const Vector3<R>& d, const Vector3<R>& p) {
  const R length2 = dot(d, d);
  return length2 > R(0) ? clamped(dot(d, p) / length2) : R(0);
}

/// Weights (their sum is 1, none is negative) of the corners 0, b and c at the point of the triangle closest to p.
template <class R>
KERNEL Vector3<R> closest_on_triangle(const Vector3<R>& b, const Vector3<R>& c, const Vector3<R>& p) {
  constexpr R kFlat = sizeof(R) == 4 ? R(1e-7) : R(1e-16);  // sin^2 of an angle: rounding takes half of the digits
  const Vector3<R> n = cross(b, c);
  const R n2 = dot(n, n);
  if (n2 > kFlat * dot(b, b) * dot(c, c)) {
    const R wb = dot(cross(p, c), n) / n2, wc = dot(cross(b, p), n) / n2, wa = R(1) - wb - wc;
    if (wa >= R(0) && wb >= R(0) && wc >= R(0)) return {wa, wb, wc};
  }
  const R ab = closest_on_segment(b, p), ac = closest_on_segment(c, p), bc = closest_on_segment(c - b, p - b);
  const Vector3<R> on_ab = p - b * ab, on_ac = p - c * ac, on_bc = p - b - (c - b) * bc;
  const R d_ab = dot(on_ab, on_ab), d_ac = dot(on_ac, on_ac), d_bc = dot(on_bc, on_bc);
  if (d_ab <= d_ac && d_ab <= d_bc) return {R(1) - ab, ab, R(0)};
  if (d_ac <= d_bc) return {R(1) - ac, R(0), ac};
  return {R(0), R(1) - bc, bc};
}

/// How far along they lie (0 to 1): the closest points of the segment of direction d from the origin, and of that of
/// direction e from r (Ericson, "Real-Time Collision Detection", 2005, section 5.1.9).
template <class R>
struct SegmentPoints {
  R s, t;
};
template <class R>
KERNEL SegmentPoints<R> closest_on_segments(const Vector3<R>& d, const Vector3<R>& e, const Vector3<R>& r) {
  constexpr R kParallel =
      sizeof(R) == 4 ? R(1e-6) : R(1e-14);  // sin^2: below it any pair across from each other will do
  const R d2 = dot(d, d), e2 = dot(e, e), de = dot(d, e), dr = dot(d, r), er = dot(e, r);
  const R area2 = d2 * e2 - de * de;
  R s = area2 > kParallel * d2 * e2 ? clamped((dr * e2 - de * er) / area2) : R(0);
  R t = e2 > R(0) ? clamped((de * s - er) / e2) : R(0);
  if (d2 > R(0)) s = clamped((de * t + dr) / d2);
  if (e2 > R(0)) t = clamped((de * s - er) / e2);
  return {s, t};
}

}  // namespace malha
