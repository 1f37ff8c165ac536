// SPDX-License-Identifier: Apache-2.0
// The nearest point of a triangle with the feature that it lies on (Ericson, "Real-Time Collision Detection", 2005,
// section 5.1.5), and the closest points of a pair of primitives (section 5.1.9) as weights of their particles,
// computed from differences of positions. Degenerate triangles and segments (no area, no length) are segments and
// points. One pair, or a pack of them, without a branch.
#pragma once
#include "kernels/simd/pack.h"
#include "kernels/simd/vec.h"

namespace malha {

/// A point of a triangle with its feature: an edge (k joins corners k and k + 1), a corner, or otherwise the face.
struct OnTriangle {
  Vector3<double> q;
  int corner = -1, edge = -1;
};

/// The same for a number or a pack S.
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
  // If several conditions hold, the first counts: corner a, b, c, edge ab, bc, ac.
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
KERNEL OnTriangle nearest_on_triangle(const Vector3<double>& p, const Vector3<double>& a, const Vector3<double>& b,
                                      const Vector3<double>& c) {
  const NearestPoint<double> nearest = nearest_point(p, a, b, c);
  return on_triangle(nearest.q, int(nearest.feature));
}

/// Pair of primitives with four particles: a particle and a triangle, or two edges, one primitive after the other.
enum class PairKind { Face, Edges };

/// Number of particles of the first primitive.
KERNEL constexpr int first_side(PairKind kind) { return kind == PairKind::Face ? 1 : 2; }

template <class S>
KERNEL S clamped(const S& t) {
  return min(max(t, S(0)), S(1));
}

/// Parameter of the point closest to p on the segment of direction d from the origin: 0 at its start, 1 at its end.
template <class S>
KERNEL S closest_on_segment(const Vector3<S>& d, const Vector3<S>& p) {
  const S zero(0), length2 = dot(d, d);
  return select(length2 > zero, clamped(dot(d, p) / length2), zero);
}

/// Computes the weights of the closest points, positive for the first primitive and negative for the second; their sum
/// is 0. Returns a mask: whether they lie in the interior of both edges, or, of a particle and a triangle, always.
template <PairKind kind, class S>
KERNEL auto weigh(const Vector3<S> (&x)[4], S (&w)[4]) {
  using R = typename RealOf<S>::type;
  const S zero(0), one(1);
  if constexpr (kind == PairKind::Face) {
    constexpr R kFlat = sizeof(R) == 4 ? R(1e-7) : R(1e-16);  // sin^2 of an angle: rounding takes half of the digits
    const Vector3<S> b = x[2] - x[1], c = x[3] - x[1], p = x[0] - x[1], n = cross(b, c);
    const S n2 = dot(n, n), per = one / n2;
    const S wb = dot(cross(p, c), n) * per, wc = dot(cross(b, p), n) * per, wa = one - wb - wc;
    const auto inside = (n2 > S(kFlat) * dot(b, b) * dot(c, c)) & (wa > zero) & (wb > zero) & (wc > zero);
    const S ab = closest_on_segment(b, p), ac = closest_on_segment(c, p), bc = closest_on_segment(c - b, p - b);
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
    constexpr R kParallel = sizeof(R) == 4 ? R(1e-6) : R(1e-14);  // sin^2: below it segments count as parallel
    const Vector3<S> d = x[1] - x[0], e = x[3] - x[2], r = x[2] - x[0];
    const S d2 = dot(d, d), e2 = dot(e, e), de = dot(d, e), dr = dot(d, r), er = dot(e, r), area2 = d2 * e2 - de * de;
    S s = select(area2 > S(kParallel) * d2 * e2, clamped((dr * e2 - de * er) / area2), zero);
    S t = select(e2 > zero, clamped((de * s - er) / e2), zero);
    s = select(d2 > zero, clamped((de * t + dr) / d2), s);
    t = select(e2 > zero, clamped((de * s - er) / e2), t);
    w[0] = one - s, w[1] = s, w[2] = t - one, w[3] = -t;
    return (s > zero) & (s < one) & (t > zero) & (t < one);
  }
}

/// The vector from the second primitive's closest point to the first's, from differences, without cancellation far from
/// the origin.
template <class S>
KERNEL Vector3<S> closest_offset(const Vector3<S>* x, const S* w) {
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

/// Weights (their sum is 1, none is negative) of the corners 0, b and c at the point of the triangle closest to p.
KERNEL Vector3<double> closest_on_triangle(const Vector3<double>& b, const Vector3<double>& c,
                                           const Vector3<double>& p) {
  constexpr double kFlat = 1e-16;  // as in weigh()
  const Vector3<double> n = cross(b, c);
  const double n2 = dot(n, n);
  if (n2 > kFlat * dot(b, b) * dot(c, c)) {
    const double wb = dot(cross(p, c), n) / n2, wc = dot(cross(b, p), n) / n2, wa = 1 - wb - wc;
    if (wa >= 0 && wb >= 0 && wc >= 0) return {wa, wb, wc};
  }
  const double ab = closest_on_segment(b, p), ac = closest_on_segment(c, p), bc = closest_on_segment(c - b, p - b);
  const Vector3<double> on_ab = p - b * ab, on_ac = p - c * ac, on_bc = p - b - (c - b) * bc;
  const double d_ab = dot(on_ab, on_ab), d_ac = dot(on_ac, on_ac), d_bc = dot(on_bc, on_bc);
  if (d_ab <= d_ac && d_ab <= d_bc) return {1 - ab, ab, 0};
  if (d_ac <= d_bc) return {1 - ac, 0, ac};
  return {0, 1 - bc, bc};
}

/// Computes the weights of the closest points of one pair in double, as weigh() does for packs, but for a triangle with
/// a rounding less. `first`: number of particles of the first primitive.
KERNEL void closest_weights(int first, const Vector3<double> (&x)[4], double (&w)[4]) {
  if (first == first_side(PairKind::Edges)) {
    weigh<PairKind::Edges>(x, w);
  } else {
    const Vector3<double> of = closest_on_triangle(x[2] - x[1], x[3] - x[1], x[0] - x[1]);
    w[0] = 1, w[1] = -of.x, w[2] = -of.y, w[3] = -of.z;
  }
}

}  // namespace malha
