// SPDX-License-Identifier: Apache-2.0
// The closest points of a particle and a triangle, or of two edges, as weights of their four particles: one pair, or a
// pack of them without a branch. The same points as kernels/geometry/closest.h, up to rounding.
#pragma once
#include "kernels/geometry/closest.h"
#include "kernels/simd/pack.h"

namespace malha {

/// Of four particles. A particle and a triangle: the particle first. Two edges: the ends of the one, then of the other.
enum class PairKind { Face, Edges };

/// How many of the four are the one side.
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

/// Fills in the weights, positive on the one side and negative on the other; their sum is 0. Returns where the closest
/// points lie inside both edges, or anywhere of a triangle.
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

/// From the other side's closest point to the one's. Weighted differences: nothing cancels far from the origin.
template <class S>
KERNEL Vector3<S> apart_by(const Vector3<S> (&x)[4], const S (&w)[4]) {
  return (x[1] - x[0]) * w[1] + (x[2] - x[0]) * w[2] + (x[3] - x[0]) * w[3];
}

/// The lowest of four numbers on the one side, less the highest on the other.
template <PairKind kind, class S>
KERNEL S gap_along_normal(const S (&at)[4]) {
  if constexpr (kind == PairKind::Face)
    return at[0] - max(at[1], max(at[2], at[3]));
  else
    return min(at[0], at[1]) - max(at[2], at[3]);
}

}  // namespace malha
