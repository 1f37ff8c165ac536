// SPDX-License-Identifier: Apache-2.0
// neo_hookean: a tetrahedron of stable neo-Hookean material (Smith, de Goes, Kim 2018), as the constraints of Macklin,
// Müller 2021, "A Constraint-based Formulation of Stable Neo-Hookean Materials". Energy
//   U = V (mu/2 (I - ln(1 + I)) + lambda/2 (J - gamma)^2), I = tr(F^T F), J = det F,
// F the deformation gradient, gamma = 1 + 3/4 mu/lambda so that there is no force at rest. No rotation is extracted,
// and flat and inverted tetrahedra have forces like others. (Macklin, Müller leave out the logarithm; then collapse to
// a point is a second minimum, in which a compressed body can stay.)
//
// The two constraints are C_D, such that mu V C_D^2 is the first part, and C_H = J - gamma of compliance 1/(lambda V).
// At rest both are strained, and only the sum of their forces is 0. Projected one after the other they converge to an
// equilibrium other than the rest shape, and jitter where stiff; here both are solved together, with the curvature that
// C_D's gradient omits: the rest shape is an equilibrium up to rounding.
#pragma once
#include "kernels/projection/direction.h"
#include "kernels/projection/project_constraint.h"
#include "kernels/simd/elementary_functions.h"

namespace malha {

struct NeoHookean {
  static constexpr const char* name = "neo_hookean";
  static constexpr Element element = Element::Tetrahedra;
  static constexpr int particles = 4;
  static constexpr bool inequality = false;
  static constexpr Strength strength{false, "young_modulus", "Pa"};
  static constexpr Filtered filtered = Filtered::After;
  static constexpr int rest_values = 7;
  static constexpr int multipliers = 2;  // projected by step(); the compliance is 1/mu
  static constexpr Parameter parameter{"poisson_ratio", 0.3, 0, true,
                                       0.499};  // nearly incompressible: mu / lambda is 0.002

  /// mu, Pa, from Young's modulus E and Poisson's ratio nu: 4/3 of linear elasticity's, because the logarithm softens
  /// it.
  KERNEL static double shear_modulus(double E, double nu) { return E / (2 * (1 + nu)) * 4 / 3; }
  /// Compliance of the constraint, from Young's modulus E (Pa).
  KERNEL static double compliance(double E, double nu) { return 1 / shear_modulus(E, nu); }
  /// mu / lambda with lambda = Lamé's + 5/6 of linear elasticity's mu, so that small strains are those of linear
  /// elasticity.
  template <class S>
  KERNEL static S ratio(S nu) {
    return S(8) * (S(1) - (nu + nu)) / (S(5) + nu + nu);
  }

  /// Q = Dm^-1 of the edges from X0 in a frame in which it is upper triangular (the material is isotropic), row by row:
  /// Q00, Q01, Q02, Q11, Q12, Q22 in 1/m; and mu / lambda. V = 1 / (6 Q00 Q11 Q22).
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[4], S nu, S (&rest)[7]) {
    const S one(1), zero(0);
    const Vector3<S> a = X[1] - X[0], b = X[2] - X[0], c = X[3] - X[0], n = cross(a, b);
    // a = (r00, 0, 0), b = (r01, r11, 0), c = (r02, r12, r22). A flat tetrahedron has a zero gradient.
    const S r00 = sqrt(dot(a, a)), area = sqrt(dot(n, n)), V = dot(n, c);
    const auto full = (r00 > zero) & (area > zero) & (V * V > zero);
    const S p00 = one / select(full, r00, one), p = one / select(full, area, one);
    const S r11 = area * p00, r22 = V * p, r01 = dot(a, b) * p00, r02 = dot(a, c) * p00;
    const S r12 = dot(cross(n, a), c) * p * p00;
    const S q11 = one / select(full, r11, one), q22 = one / select(full, r22, one);
    const S q[6] = {p00, -r01 * p00 * q11, (r01 * r12 * q11 - r02) * p00 * q22, q11, -r12 * q11 * q22, q22};
    for (int k = 0; k < 6; ++k) rest[k] = select(full, q[k], zero);
    rest[6] = ratio(nu);
  }

  /// C = sqrt(2 U / (mu V)), whose gradient is the direction of the elastic force.
  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[4], const S* rest, const Mask& valid, Vector3<S> (&grad)[4],
                           S& scale) {
    const S one(1);
    const auto whole = valid & (rest[6] > S(0));
    const Deformed<S> now(p, rest, whole);
    const S r = select(whole, rest[6], one);
    const S excess = (now.J - now.gamma(r)) / r;  // lambda/mu (J - gamma)
    const S C = sqrt(now.F2 - logarithm(one + now.F2) + excess * excess * r);
    const S per_C = one / select(C > S(tiny<S>()), C, one);
    now.pull(excess * per_C, -now.softening() * per_C, grad);
    scale = one;
    return C;
  }

  /// Volume at rest, m^3.
  KERNEL static double volume(const double* rest) { return 1 / (6 * rest[0] * rest[3] * rest[5]); }

  /// The energy over mu, m^3: 0 at rest.
  KERNEL static double energy(const Vector3<double> (&p)[4], const double* rest) {
    const Deformed<double> now(p, rest, true);
    const double r = rest[6], gamma = now.gamma(r), V = volume(rest);
    const double at_rest = 3 - log1p(3.0) + (1 - gamma) * (1 - gamma) / r;
    return V / 2 * (now.F2 - log1p(now.F2) + (now.J - gamma) * (now.J - gamma) / r - at_rest);
  }

  /// Projects both constraints together: `move` in m/w, p += w move. `alpha`: 1 / (mu dt^2). `sum`: their multipliers
  /// sum_D, sum_H in this substep, which are updated.
  ///
  /// A move by G P (G: the gradients of F's columns) changes F by at most b P, b >= sum w G G^T. With
  ///   P = y cof F - s F, s = d / k, y = (tau - alpha~ sum_H) / k, d = I / (1 + I) - alpha~ sum_D / |F|,
  ///   tau (mu/lambda + b/k |cof F|^2) = gamma - J + b/k (3 J d + alpha~ sum_H |cof F|^2)
  /// C_H's equation holds after the step. The stiffness k is the inertia alpha~, so that small steps are exact, but at
  /// least 3/2 b, the stiffness of shear, to which F and cof F both contribute, so that a step does not overshoot. P
  /// F^T is symmetric, which conserves angular momentum.
  template <class S, class Mask>
  KERNEL static void step(const Vector3<S> (&p)[4], const Vector3<S> (&x)[4], const S (&w)[4], const S* rest,
                          const Mask& valid, S alpha, S max_start_step, S (&sum)[2], Vector3<S> (&move)[4]) {
    const S zero(0), one(1);
    const Deformed<S> now(p, rest, valid);
    const S b = now.response(w);
    const auto moves = valid & (b > S(tiny<S>())) & (now.F2 > S(tiny<S>()));
    const S own = alpha * S(6) * now.q[0] * now.q[3] * now.q[5];
    const S per_k = one / select(moves, max(own, b * S(1.5)), one), part = b * per_k;
    const S size = sqrt(now.F2), r = rest_or_zero(valid, rest[6]);
    const S left_D = now.softening() - own * sum[0] / select(moves, size, one), met_H = own * sum[1];
    const S c2 = now.cofactor2();
    const S needed = now.gamma(r) - now.J + part * (S(3) * now.J * left_D + met_H * c2);
    const S tau = needed / select(moves, r + part * c2, one);
    const S shrink = select(moves, left_D * per_k, zero), stretch = select(moves, (tau - met_H) * per_k, zero);
    sum[0] = sum[0] + shrink * size, sum[1] = sum[1] + stretch;
    now.pull(stretch, shrink, move);
    Vector3<S> along[4], carried[4];
    const Deformed<S> then(x, rest, valid);
    then.pull(stretch, shrink, along), then.pull(sum[1], sum[0] / select(moves, size, one), carried);
    blend_with_start(max_start_step, relative_displacement2(w, carried, x), w, along, move);
  }

 private:
  template <class S, class Mask>
  KERNEL static S rest_or_zero(const Mask& valid, const S& a) {
    return select(valid, a, S(0));
  }

  template <class S>
  struct Deformed {
    S q[6];
    Vector3<S> f[3], c[3];  // columns of F and of its cofactors
    S J, F2;                // det F, tr(F^T F)

    template <class Mask>
    KERNEL Deformed(const Vector3<S> (&p)[4], const S* rest, const Mask& valid) {
      for (int k = 0; k < 6; ++k) q[k] = rest_or_zero(valid, rest[k]);
      const Vector3<S> a = or_zero(valid, p[1] - p[0]), b = or_zero(valid, p[2] - p[0]),
                       d = or_zero(valid, p[3] - p[0]);
      f[0] = a * q[0], f[1] = a * q[1] + b * q[3], f[2] = a * q[2] + b * q[4] + d * q[5];
      F2 = dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]);
      // Stretches are clamped to 10^4, so that squares of det F stay in float's range.
      const S far(1e4), one(1), fit = select(F2 > far * far, far / sqrt(max(F2, one)), one);
      for (Vector3<S>& column : f) column = column * fit;
      F2 = select(F2 > far * far, far * far, F2);
      c[0] = cross(f[1], f[2]), c[1] = cross(f[2], f[0]), c[2] = cross(f[0], f[1]);
      J = dot(f[0], c[0]);
    }

    /// I / (1 + I): the factor of F's force by the logarithm.
    KERNEL S softening() const { return F2 / (F2 + S(1)); }
    KERNEL static S gamma(const S& ratio) { return S(1) + S(0.75) * ratio; }
    KERNEL S cofactor2() const { return dot(c[0], c[0]) + dot(c[1], c[1]) + dot(c[2], c[2]); }

    /// Computes the corrections by G P. Q's rows are the gradients of F's columns at p1, p2, p3; at p0 they are minus
    /// their sum.
    KERNEL void pull(S y, S x, Vector3<S> (&move)[4]) const {
      Vector3<S> P[3];
      for (int j = 0; j < 3; ++j) P[j] = c[j] * y - f[j] * x;
      move[1] = P[0] * q[0] + P[1] * q[1] + P[2] * q[2];
      move[2] = P[1] * q[3] + P[2] * q[4];
      move[3] = P[2] * q[5];
      move[0] = -(move[1] + move[2] + move[3]);
    }

    /// An upper bound of the largest eigenvalue of sum w G G^T, by Gershgorin.
    KERNEL S response(const S (&w)[4]) const {
      const S g1 = q[1] + q[3], g2 = q[2] + q[4] + q[5];
      const S B00 = (w[0] + w[1]) * q[0] * q[0];
      const S B01 = abs(q[0] * (w[0] * g1 + w[1] * q[1])), B02 = abs(q[0] * (w[0] * g2 + w[1] * q[2]));
      const S B11 = w[0] * g1 * g1 + w[1] * q[1] * q[1] + w[2] * q[3] * q[3];
      const S B12 = abs(w[0] * g1 * g2 + w[1] * q[1] * q[2] + w[2] * q[3] * q[4]);
      const S B22 = w[0] * g2 * g2 + w[1] * q[2] * q[2] + w[2] * q[4] * q[4] + w[3] * q[5] * q[5];
      return max(max(B00 + B01 + B02, B01 + B11 + B12), B02 + B12 + B22);
    }
  };
};

}  // namespace malha
