// SPDX-License-Identifier: Apache-2.0
// The point of a triangle that is nearest to a point (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5):
// one triangle with branches, and one or a pack of them without. Both do the same arithmetic, to the bit.
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

/// Where on a triangle: on an edge (k joins corners k and k + 1), at a corner, or else on the face.
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

/// The same for S a number or a pack: not a number where nearest_on_triangle has none. Zeros may differ in their sign.
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
  // Of several that hold, the first in the order of nearest_on_triangle counts.
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

}  // namespace malha
