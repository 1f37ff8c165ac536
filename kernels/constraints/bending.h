// SPDX-License-Identifier: Apache-2.0
// bending: C = theta - theta0, the signed dihedral angle between the triangles (p0, p1, p2) and (p1, p0, p3).
// The 2006 paper's acos(n1.n2) is blind to the side of the fold and singular at 0 and pi; this is the signed angle,
// with the gradients of Bridson, Marino, Fedkiw 2003 (also Tamstorf, Grinspun 2013).
#pragma once
#include "kernels/constraints/isometric_bending.h"
#include "kernels/simd/elementary_functions.h"

namespace malha {

struct Bending {
  static constexpr const char* name = "bending";
  static constexpr Element element = Element::Hinges;
  static constexpr int particles = 4;
  static constexpr bool inequality = false;
  static constexpr Strength strength{true, "rigidity", "N m"};
  static constexpr Filtered filtered = Filtered::Stencil;
  using Stencil = IsometricBending::Stencil;
  static constexpr int rest_values = 2;
  static constexpr double min_turn_cosine = 0.97;
  static constexpr int per_max_step = 1;
  static constexpr Parameter parameter{"rest_scale", 1, 0, true};

  /// theta0, rad: the angle at rest times rest_scale (0: flat). 1 / max step, 1/m, from the smaller height over the
  /// edge: a straight step approximates a rotation about the edge if it is short beside that. (The height is that at
  /// rest, because a straight step also stretches the triangles, and a bound by the current height would grow with it.)
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[4], S rest_scale, S (&rest)[2]) {
    const S zero(0), one(1);
    Vector3<S> grad[4];
    S scale;
    rest[0] = zero;
    rest[0] = evaluate(X, rest, true, grad, scale) * rest_scale;
    const Vector3<S> e = X[1] - X[0], n1 = cross(e, X[2] - X[0]), n2 = cross(e, X[3] - X[0]);
    const S a1 = dot(n1, n1), a2 = dot(n2, n2), e2 = dot(e, e);
    rest[1] = per_max_step_of(sqrt(select(a1 < a2, a1, a2) / select(e2 > zero, e2, one)));
  }

  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[4], const S* rest, const Mask& valid, Vector3<S> (&grad)[4],
                           S& scale) {
    const S zero(0), one(1);
    scale = one;
    const Vector3<S> e = p[1] - p[0];
    const Vector3<S> from0to2 = p[2] - p[0], from1to2 = p[2] - p[1];
    const Vector3<S> from0to3 = p[3] - p[0], from1to3 = p[3] - p[1];
    const Vector3<S> n1 = cross(e, from0to2), n2 = cross(from0to3, e);
    const S e2 = dot(e, e), a1 = dot(n1, n1), a2 = dot(n2, n2);
    // A triangle without area has no normal, and a zero gradient skips it. Areas are compared with the edge, whatever
    // the scale.
    const S sliver = e2 * e2 * S(1e-12);
    const auto whole = (select(a1 < a2, a1, a2) > max(sliver, S(tiny<S>()))) & valid;
    const S length = sqrt(select(whole, e2, one));
    const S u1 = one / select(whole, a1, one), u2 = one / select(whole, a2, one);
    const Vector3<S> m1 = n1 * u1, m2 = n2 * u2;
    const S per_edge = one / length;
    grad[2] = or_zero(whole, m1 * -length);
    grad[3] = or_zero(whole, m2 * -length);
    grad[0] = or_zero(whole, m1 * (-dot(from1to2, e) * per_edge) + m2 * (-dot(from1to3, e) * per_edge));
    grad[1] = or_zero(whole, m1 * (dot(from0to2, e) * per_edge) + m2 * (dot(from0to3, e) * per_edge));
    const S theta = arctangent2(dot(e, cross(n1, n2)) * per_edge, dot(n1, n2));
    const S pi(3.14159265358979323846), turn = pi + pi;
    S C = theta - rest[0];
    C = select(C > pi, C - turn, select(C < -pi, C + turn, C));
    return select(whole, C, zero);
  }
};

}  // namespace malha
