// SPDX-License-Identifier: Apache-2.0
// Closest points of a point and a triangle, and of two segments, as weights of their ends; computed from differences of
// positions. Degenerate triangles and segments (no area, no length) are segments and points. Then the nearest point of
// a triangle with the feature that it lies on (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5), and the
// closest points of a pair of primitives, one pair or a pack of them without a branch: the same points up to rounding.
#pragma once
#include "kernels/simd/pack.h"
#include "kernels/simd/vec.h"

namespace malha {

template <class R>
KERNEL R clamped(R t) {
  const R least = t > R(0) ? t : R(0);
  return least < R(1) ? least : R(1);  // without a branch, which would be unpredictable
}

/// Parameter of the point closest to p on the segment of direction d from the origin: 0 at its start, 1 at its end.
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

/// Parameters (0 to 1) of the closest points of the segment of direction d from the origin and of the segment of
/// direction e from r (Ericson, "Real-Time Collision Detection", 2005, section 5.1.9).
template <class R>
struct SegmentPoints {
  R s, t;
};
template <class R>
KERNEL SegmentPoints<R> closest_on_segments(const Vector3<R>& d, const Vector3<R>& e, const Vector3<R>& r) {
  constexpr R kParallel = sizeof(R) == 4 ? R(1e-6) : R(1e-14);  // sin^2: below it segments count as parallel
  const R d2 = dot(d, d), e2 = dot(e, e), de = dot(d, e), dr = dot(d, r), er = dot(e, r);
  const R area2 = d2 * e2 - de * de;
  R s = area2 > kParallel * d2 * e2 ? clamped((dr * e2 - de * er) / area2) : R(0);
  R t = e2 > R(0) ? clamped((de * s - er) / e2) : R(0);
  if (d2 > R(0)) s = clamped((de * t + dr) / d2);
  if (e2 > R(0)) t = clamped((de * s - er) / e2);
  return {s, t};
}

/// A point of a triangle with its feature: an edge (k joins corners k and k + 1), a corner, or otherwise the face.
struct OnTriangle {
  Vector3<double> q;
  int corner = -1, edge = -1;
};

KERNEL OnTriangle nearest_on_triangle(const Vector3<double>& p, const Vector3<double>& a, const Vector3<double>& b,
                                      const Vector3<double>& c) {
  const Vector3<double> ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {a, 0, -1};
  if (d3 >= 0 && d4 <= d3) return {b, 1, -1};
  if (d6 >= 0 && d5 <= d6) return {c, 2, -1};
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + ab * (d1 / (d1 - d3)), -1, 0};
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6)), -1, 1};
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + ac * (d2 / (d2 - d6)), -1, 2};
  const double per = 1 / (va + vb + vc);
  return {a + ab * (vb * per) + ac * (vc * per), -1, -1};
}

/// The same for a number or a pack S: NaN where nearest_on_triangle gives NaN. Zeros may differ in sign.
template <class S>
struct NearestPoint {
  Vector3<S> q;
  S feature;  // 0 to 2: that corner, 3 to 5: that edge, 6: the face
};

template <class S>
KERNEL NearestPoint<S> nearest_point(const Vector3<S>& p, const Vector3<S>& a, const Vector3<S>& b,
                                     const Vector3<S>& c) {
  const S zero(0.0), one(1.0);
  const Vector3<S> ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const S d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
  const S va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2, d43 = d4 - d3, d56 = d5 - d6;
  const auto not_a = (d1 > zero) | (d2 > zero), not_b = (d3 < zero) | (d4 > d3), not_c = (d6 < zero) | (d5 > d6);
  const auto not_ab = (vc > zero) | (d1 < zero) | (d3 > zero), not_bc = (va > zero) | (d43 < zero) | (d56 < zero);
  const auto not_ac = (vb > zero) | (d2 < zero) | (d6 > zero);
  // If several conditions hold, the first in the order of nearest_on_triangle counts.
  const S over = select(not_ab, select(not_bc, select(not_ac, one, d2), d43), d1);
  const S under = select(not_ab, select(not_bc, select(not_ac, va + vb + vc, d2 - d6), d43 + d5 - d6), d1 - d3);
  const S r = over / under;
  const auto no_corner = not_a & not_b & not_c, not_two = not_ab & not_bc;
  const S s = select(no_corner, select(not_two, select(not_ac, vb * r, zero), r), zero);
  const S u = select(no_corner, select(not_two, select(not_ac, vc * r, r), zero), zero);
  const auto pick = [&](S at_a, S at_b, S at_c) KERNEL_LAMBDA {
    const S base = select(not_ab, select(not_bc, at_a, at_b), at_a);
    return select(not_a, select(not_b, select(not_c, base, at_c), at_b), at_a);
  };
  const auto way = [&](S on_ab, S on_bc) KERNEL_LAMBDA { return select(not_ab, select(not_bc, on_ab, on_bc), on_ab); };
  const Vector3<S> start{pick(a.x, b.x, c.x), pick(a.y, b.y, c.y), pick(a.z, b.z, c.z)};
  const Vector3<S> along{way(ab.x, c.x - b.x), way(ab.y, c.y - b.y), way(ab.z, c.z - b.z)};
  const S edge = select(not_ab, select(not_bc, select(not_ac, S(6.0), S(5.0)), S(4.0)), S(3.0));
  const S feature = select(not_a, select(not_b, select(not_c, edge, S(2.0)), one), zero);
  return {start + along * s + ac * u, feature};
}

KERNEL OnTriangle on_triangle(const Vector3<double>& q, int feature) {
  return {q, feature < 3 ? feature : -1, feature >= 3 && feature < 6 ? feature - 3 : -1};
}

/// Pair of primitives with four particles: a particle and a triangle, or two edges, one primitive after the other.
enum class PairKind { Face, Edges };

/// Number of particles of the first primitive.
KERNEL constexpr int first_side(PairKind kind) { return kind == PairKind::Face ? 1 : 2; }

template <class S>
KERNEL S clamped_lanes(const S& t) {
  using R = typename RealOf<S>::type;
  return min(max(t, S(R(0))), S(R(1)));
}

template <class S>
KERNEL S nearest_on(const Vector3<S>& d, const Vector3<S>& p) {
  const S zero(typename RealOf<S>::type(0)), length2 = dot(d, d);
  return select(length2 > zero, clamped_lanes(dot(d, p) / length2), zero);
}

/// Computes the weights of the closest points, positive for the first primitive and negative for the second; their sum
/// is 0. Returns a mask: whether they lie in the interior of both edges, or, of a particle and a triangle, always.
template <PairKind kind, class S>
KERNEL auto weigh(const Vector3<S> (&x)[4], S (&w)[4]) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1));
  if constexpr (kind == PairKind::Face) {
    constexpr R kFlat = sizeof(R) == 4 ? R(1e-7) : R(1e-16);  // as in closest_on_triangle
    const Vector3<S> b = x[2] - x[1], c = x[3] - x[1], p = x[0] - x[1], n = cross(b, c);
    const S n2 = dot(n, n), per = one / n2;
    const S wb = dot(cross(p, c), n) * per, wc = dot(cross(b, p), n) * per, wa = one - wb - wc;
    const auto inside = (n2 > S(kFlat) * dot(b, b) * dot(c, c)) & (wa > zero) & (wb > zero) & (wc > zero);
    const S ab = nearest_on(b, p), ac = nearest_on(c, p), bc = nearest_on(c - b, p - b);
    const Vector3<S> on_ab = p - b * ab, on_ac = p - c * ac, on_bc = p - b - (c - b) * bc;
    const S d_ab = dot(on_ab, on_ab), d_ac = dot(on_ac, on_ac), d_bc = dot(on_bc, on_bc);
    const auto not_ab = (d_ab > d_ac) | (d_ab > d_bc);
    const auto not_ac = d_ac > d_bc;
    w[0] = one;
    w[1] = -select(inside, wa, select(not_ab, select(not_ac, zero, one - ac), one - ab));
    w[2] = -select(inside, wb, select(not_ab, select(not_ac, one - bc, zero), ab));
    w[3] = -select(inside, wc, select(not_ab, select(not_ac, bc, ac), zero));
    return n2 <= n2;
  } else {
    constexpr R kParallel = sizeof(R) == 4 ? R(1e-6) : R(1e-14);  // as in closest_on_segments
    const Vector3<S> d = x[1] - x[0], e = x[3] - x[2], r = x[2] - x[0];
    const S d2 = dot(d, d), e2 = dot(e, e), de = dot(d, e), dr = dot(d, r), er = dot(e, r), area2 = d2 * e2 - de * de;
    S s = select(area2 > S(kParallel) * d2 * e2, clamped_lanes((dr * e2 - de * er) / area2), zero);
    S t = select(e2 > zero, clamped_lanes((de * s - er) / e2), zero);
    s = select(d2 > zero, clamped_lanes((de * t + dr) / d2), s);
    t = select(e2 > zero, clamped_lanes((de * s - er) / e2), t);
    w[0] = one - s, w[1] = s, w[2] = t - one, w[3] = -t;
    return (s > zero) & (s < one) & (t > zero) & (t < one);
  }
}

/// The vector from the second primitive's closest point to the first's, from differences, without cancellation far from
/// the origin.
template <class S>
KERNEL Vector3<S> closest_difference(const Vector3<S> (&x)[4], const S (&w)[4]) {
  return (x[1] - x[0]) * w[1] + (x[2] - x[0]) * w[2] + (x[3] - x[0]) * w[3];
}

/// The smallest of the numbers of the first primitive less the largest of the second.
template <PairKind kind, class S>
KERNEL S gap_along_normal(const S (&at)[4]) {
  if constexpr (kind == PairKind::Face)
    return at[0] - max(at[1], max(at[2], at[3]));
  else
    return min(at[0], at[1]) - max(at[2], at[3]);
}

/// Computes the weights of the closest points of one pair in double, as weigh() does for packs. `first`: number of
/// particles of the first primitive.
KERNEL void closest_weights(int first, const Vector3<double>* x, double* weight) {
  if (first == 1) {
    const Vector3<double> w = closest_on_triangle(x[2] - x[1], x[3] - x[1], x[0] - x[1]);
    weight[0] = 1, weight[1] = -w.x, weight[2] = -w.y, weight[3] = -w.z;
  } else {
    const SegmentPoints<double> at = closest_on_segments(x[1] - x[0], x[3] - x[2], x[2] - x[0]);
    weight[0] = 1 - at.s, weight[1] = at.s, weight[2] = at.t - 1, weight[3] = -at.t;
  }
}

/// The vector from the second primitive's closest point to the first's, from the weights of closest_weights().
KERNEL Vector3<double> closest_offset(const Vector3<double>* x, const double* weight) {
  return (x[1] - x[0]) * weight[1] + (x[2] - x[0]) * weight[2] + (x[3] - x[0]) * weight[3];
}

}  // namespace malha
