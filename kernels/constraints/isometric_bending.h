// SPDX-License-Identifier: Apache-2.0
// isometric_bending: C = +-|sum K_j p_j| -+ |sum K_j X_j| over the four particles of a hinge, with K its cotangent
// weights at rest over the edge: the length 2 sin(theta / 2) of the fold vector, with the sign of the side to which it
// folds, so that a hinge that is curved at rest has no second rest shape on the other side. For small folds this is the
// angle, so that a compliance or rigidity means the same as for bending. The energy of a hinge that is flat at rest is
// quadratic in the positions, and no current triangle can make it degenerate. Meant for nearly inextensible sheets
// (Bergou et al. 2006, section 4).
#pragma once
#include "kernels/projection/project_constraint.h"

namespace malha {

struct IsometricBending {
  static constexpr const char* name = "isometric_bending";
  static constexpr Element element = Element::Hinges;
  static constexpr int particles = 4;
  static constexpr bool inequality = false;
  static constexpr Strength strength{true, "rigidity", "N m"};
  static constexpr Filtered filtered = Filtered::Stencil;
  static constexpr int rest_values = 4;
  static constexpr Parameter parameter{"rest_scale", 1, 0, true};
  static constexpr double min_turn_cosine = 0.97;

  /// The signed length of the fold vector at rest times rest_scale (0: flat), and K_0 to K_2, 1/m; K_3 is minus their
  /// sum. All are 0 for a hinge with a triangle without area.
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[4], S rest_scale, S (&rest)[4]) {
    const S zero(0), one(1);
    const Vector3<S> e = X[1] - X[0], a = X[2] - X[0], b = X[3] - X[0];
    const S e2 = dot(e, e), n1 = sqrt(dot(cross(e, a), cross(e, a))), n2 = sqrt(dot(cross(e, b), cross(e, b)));
    const auto whole = select(n1 < n2, n1, n2) > max(e2 * S(1e-6), S(tiny<S>()));
    // Cotangents of the angles at both ends of the edge, in both triangles; all over the edge.
    const S length = sqrt(e2), per_edge = one / select(whole, length, one);
    const S u1 = per_edge / select(whole, n1, one), u2 = per_edge / select(whole, n2, one);
    const S at0 = dot(e, a) * u1 + dot(e, b) * u2, at1 = (e2 - dot(e, a)) * u1 + (e2 - dot(e, b)) * u2;
    rest[0] = zero;
    rest[1] = select(whole, at1, zero), rest[2] = select(whole, at0, zero), rest[3] = select(whole, -e2 * u1, zero);
    const Vector3<S> fold = fold_of(X, rest);
    const S folded = sqrt(dot(fold, fold));  // for a flat hinge, the rounding error of its weights
    rest[0] = select(folded > S(1e-9), folded * side_of(X, rest, fold) * rest_scale, zero);
  }

  /// C and its gradients times |sum K_j p_j|, as Distance does.
  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[4], const S* rest, const Mask& valid, Vector3<S> (&grad)[4],
                           S& scale) {
    const Vector3<S> fold = or_zero(valid, fold_of(p, rest));
    // A hinge that is flat at rest has no side, and a multiplier of one sign.
    const S flat(0), side = select(rest[0] == flat, S(1), side_of(p, rest, fold));
    for (int j = 0; j < 3; ++j) grad[j] = or_zero(valid, fold * (rest[1 + j] * side));
    grad[3] = -(grad[0] + grad[1] + grad[2]);
    scale = sqrt(dot(fold, fold));
    return scale * (scale * side - rest[0]);
  }

  /// The normal of a hinge: the unit vector halfway between those of its triangles, along which the fold vector of an
  /// isometrically bent hinge lies. It is 0 where both triangles have no area, or lie on each other.
  template <class S>
  KERNEL static Vector3<S> normal_of(const Vector3<S> (&p)[4]) {
    const Vector3<S> e = p[1] - p[0];
    return unit(unit(cross(e, p[2] - p[0])) + unit(cross(p[3] - p[0], e)));
  }

  /// In the filter both bending kinds are the fold vector, pulled to its length at rest: near rest they have the same
  /// energy, of which this is the form with a constant Hessian.
  struct Stencil {
    static constexpr int vectors = 1, coefficients = 1;
    template <class S>
    KERNEL static void weights(const Vector3<S> (&X)[4], S rest_scale, S (&c)[1][4], S (&own)[1]) {
      S of[4];
      rest(X, rest_scale, of);
      own[0] = of[0];
      for (int j = 0; j < 3; ++j) c[0][j] = of[1 + j];
      c[0][3] = -(of[1] + of[2] + of[3]);
    }
    template <class S>
    KERNEL static void target(const Vector3<S> (&f)[1], const S* own, Vector3<S> (&d)[1]) {
      const S zero(0), one(1), length = sqrt(dot(f[0], f[0]));
      d[0] = f[0] * select(length > zero, abs(own[0]) / select(length > zero, length, one), zero);
    }
    /// The fold at rest along the normal now: it stays on the side on which it is at rest.
    template <class S>
    KERNEL static void target_by_normals(const Vector3<S> (&x)[4], const S* own, Vector3<S> (&d)[1]) {
      d[0] = normal_of(x) * own[0];
    }
    /// The harmonic mean of the wings' heights over the edge, which converts the force of a spring between them to a
    /// moment about the hinge. Weights of flat triangles are unbounded; such a corner would be stiffer than any spring,
    /// and the filter's matrix would lose the digits of all others: weights times the lever are limited to 4, twice
    /// that of a grid.
    KERNEL static double lever(const Vector3<double> (&X)[4]) {
      const Vector3<double> e = X[1] - X[0], n1 = cross(e, X[2] - X[0]), n2 = cross(e, X[3] - X[0]);
      const double length = sqrt(dot(e, e)), a1 = sqrt(dot(n1, n1)), a2 = sqrt(dot(n2, n2)), sum = a1 + a2;
      if (!(length > 0) || !(sum > 0)) return 0;
      double of[4], most = 0;
      rest(X, 1.0, of);
      for (int j = 1; j < 4; ++j) most = max(most, abs(of[j]));
      most = max(most, abs(of[1] + of[2] + of[3]));
      const double mean = (a1 < a2 ? a1 : a2) * (2 * max(a1, a2) / sum) / length;
      return most * mean > 4 ? 4 / most : mean;
    }
  };

 private:
  template <class S>
  KERNEL static Vector3<S> unit(const Vector3<S>& a) {
    const S one(1), length = sqrt(dot(a, a));
    const auto is_long = length > S(tiny<S>());
    return or_zero(is_long, a * (one / select(is_long, length, one)));
  }

  template <class S>
  KERNEL static Vector3<S> fold_of(const Vector3<S> (&p)[4], const S* rest) {
    return (p[0] - p[3]) * rest[1] + (p[1] - p[3]) * rest[2] + (p[2] - p[3]) * rest[3];
  }

  /// The sign of the fold along the sum of both triangles' normals, e x (r_2 / h_2 - r_3 / h_3), with the wings r over
  /// the edge and their heights at rest, h_j = -1 / K_j. Stretch in the plane also gives a fold vector, which has no
  /// side: within 120 degrees of the side at rest it counts as on that side.
  template <class S>
  KERNEL static S side_of(const Vector3<S> (&p)[4], const S* rest, const Vector3<S>& fold) {
    const S one(1), K3 = -(rest[1] + rest[2] + rest[3]), at_rest = select(rest[0] < S(0), -one, one);
    const Vector3<S> normal = cross(p[1] - p[0], (p[3] - p[0]) * K3 - (p[2] - p[0]) * rest[3]);
    const S along = dot(fold, normal) * at_rest;
    return select(along + along < -sqrt(dot(fold, fold) * dot(normal, normal)), -at_rest, at_rest);
  }
};

}  // namespace malha
