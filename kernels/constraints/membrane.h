// SPDX-License-Identifier: Apache-2.0
// membrane: a triangle of thin elastic material, by Young's modulus times thickness Y (N/m) and Poisson's ratio nu:
// linear in its stretch S = R^T F (Biot's strain S - 1), which is free of rotation. F = (f1 f2), 3 x 2, the deformation
// gradient, and R = (r1 r2) the rotation nearest to it. Energy, with A the area at rest:
//   U = A Y / (1 - nu^2) / 2 ((1 + nu)/2 a^2 + (1 - nu)/2 (b^2 + c^2)), a = S11 + S22 - 2, b = S11 - S22, c = 2 S12,
// that of plane stress. It is half of Y times the squares of three constraints, all of compliance 1/Y, which are
// projected together:
//   C = (k_a a, k_b b, k_b c), k_a^2 = A / (2 (1 - nu)), k_b^2 = A / (2 (1 + nu)).
// Their gradients depend on F/|F| alone and are bounded, however a triangle is crushed or stretched. A triangle in
// space cannot be inverted: turned over it is only rotated.
#pragma once
#include "kernels/projection/block_solve.h"
#include "kernels/projection/project_constraint.h"

namespace malha {

/// The law of isotropic material: C = (k_a a, k_b b, k_b c).
template <class S>
struct IsotropicLaw {
  static constexpr int numbers = 2;
  S k[2];
  KERNEL void constraints(const S& a, const S& b, const S& c, S (&C)[3]) const {
    C[0] = k[0] * a, C[1] = k[1] * b, C[2] = k[1] * c;
  }
  /// Computes a, b, c = B^T part, where C = B (a, b, c).
  KERNEL void pull(const S (&part)[3], S& a, S& b, S& c) const {
    a = part[0] * k[0], b = part[1] * k[1], c = part[2] * k[1];
  }
  /// Turns A, of which the lower triangle is used, into B A B^T.
  KERNEL void surround(S (&A)[3][3]) const {
    const S aa = k[0] * k[0], ab = k[0] * k[1], bb = k[1] * k[1];
    A[0][0] = aa * A[0][0], A[1][0] = ab * A[1][0], A[2][0] = ab * A[2][0];
    A[1][1] = bb * A[1][1], A[2][1] = bb * A[2][1], A[2][2] = bb * A[2][2];
  }
};

/// The part that membranes of every law share.
template <template <class S> class Law>
struct MembraneOf {
  static constexpr Element element = Element::Triangles;
  static constexpr int particles = 3;
  static constexpr bool inequality = false;
  static constexpr Strength strength{false, "young_modulus", "N/m"};
  static constexpr Filtered filtered = Filtered::Stencil;
  static constexpr int rest_values = 3 + Law<double>::numbers;  // Q of rest_edges(), and the law
  static constexpr int multipliers = 3;
  static constexpr Parameter parameter{"poisson_ratio", 0.3, 0, true,
                                       0.95};  // at which area is 39 times as stiff as shape

  /// Compliance of the constraints, from Y (N/m).
  KERNEL static double compliance(double Y, double) { return 1 / Y; }

  /// Computes Q = Dm^-1 of the edges at X0 in a frame in which it is upper triangular: Q00, Q01, Q11, 1/m, and returns
  /// half the area, m^2. All are 0 for a triangle whose height is less than a millionth of its size.
  template <class S>
  KERNEL static S rest_edges(const Vector3<S> (&X)[3], S* rest) {
    const S zero(0), one(1);
    const Vector3<S> e = X[1] - X[0], g = X[2] - X[0], n = cross(e, g);
    const S e2 = dot(e, e), area2 = sqrt(dot(n, n));  // twice the area
    const auto long_enough = e2 > S(tiny<S>());
    const auto wide_enough = area2 > max((e2 + dot(g, g)) * S(1e-6), S(tiny<S>()));
    const auto whole = wide_enough & long_enough;
    const S per_e = one / sqrt(select(whole, e2, one)), per_area2 = one / select(whole, area2, one);
    rest[0] = select(whole, per_e, zero);
    rest[1] = select(whole, -dot(e, g) * per_e * per_area2, zero);
    rest[2] = select(whole, sqrt(e2) * per_area2, zero);
    return select(whole, area2 / S(4), zero);
  }

  /// C = sqrt(2 U / Y), a single number. Its gradient is the direction of the elastic force or, without force, that of
  /// a.
  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[3], const S* rest, const Mask& valid, Vector3<S> (&grad)[3],
                           S& scale) {
    const S zero(0), one(1);
    const Deformed<S> now(p, rest, valid);
    const S C = sqrt(now.C[0] * now.C[0] + now.C[1] * now.C[1] + now.C[2] * now.C[2]);
    const auto strained = C > S(tiny<S>());
    const S per_C = one / select(strained, C, one);
    S part[3];
    for (int m = 0; m < 3; ++m) part[m] = select(strained, now.C[m] * per_C, m == 0 ? one : zero);
    now.pull(part, grad);
    scale = one;
    return C;
  }

  /// The energy over Y, m^2.
  KERNEL static double energy(const Vector3<double> (&p)[3], const double* rest) {
    const Deformed<double> now(p, rest, true);
    return (now.C[0] * now.C[0] + now.C[1] * now.C[1] + now.C[2] * now.C[2]) / 2;
  }

  /// Projects the three constraints together: `move` in m/w, p += w move. `alpha`: 1 / (Y dt^2). `sum`: their
  /// multipliers in this substep, which are updated. The matrix has the gradients at p twice, instead of those at the
  /// start x once, which differ by the rotation of a substep: later projections correct that.
  ///
  /// The gradients rotate with R. For crushed slivers and unequal masses a full step would rotate R by radians and
  /// multiply the energy by a thousand: a step is therefore limited to a rotation of 0.2 (from random starts the energy
  /// then grows by less than an eighth), and later projections correct the rest.
  template <class S, class Mask>
  KERNEL static void step(const Vector3<S> (&p)[3], const Vector3<S> (&x)[3], const S (&w)[3], const S* rest,
                          const Mask& valid, S alpha, S max_start_step, S (&sum)[3], Vector3<S> (&move)[3]) {
    const Deformed<S> now(p, rest, valid);
    const typename Deformed<S>::Masses B(now.q, w);
    S A[3][3], dlambda[3];
    now.response(B, A);
    solve_at_once(A, now.C, alpha, sum, valid, dlambda);
    const S max_turn(0.2), omega = now.turning(B, dlambda);
    const S part = max_turn / max(max(omega, -omega), max_turn);
    for (int m = 0; m < 3; ++m) {
      dlambda[m] = dlambda[m] * part;
      sum[m] = sum[m] + dlambda[m];
    }
    Vector3<S> along[3], carried[3];
    const Deformed<S> then(x, rest, valid);
    now.pull(dlambda, move);
    then.pull(dlambda, along), then.pull(sum, carried);
    // The measure is the change of F, which for a sliver is more than displacement over size. Stretched sheets are
    // stable up to half of `max_start_step`.
    const Vector3<S> e = carried[1] * w[1] - carried[0] * w[0], g = carried[2] * w[2] - carried[0] * w[0];
    const Vector3<S> f1 = e * now.q[0], f2 = e * now.q[1] + g * now.q[2];
    blend_with_start(max_start_step, S(4) * (dot(f1, f1) + dot(f2, f2)), w, along, move);
  }

 protected:
  /// R of F: with n the normal, R = (f1 + f2 x n, f2 + n x f1) / t, t = sqrt(|F|^2 + 2 |f1 x f2|) = tr S.
  template <class S>
  struct Turned {
    Vector3<S> r[2];
    S per_t;

    template <class Mask>
    KERNEL Turned(const Vector3<S> (&f)[2], const Mask& valid) {
      const S zero(0), one(1), F2 = dot(f[0], f[0]) + dot(f[1], f[1]);
      const auto whole = valid & (F2 > S(1e-12));  // otherwise all corners coincide
      // A triangle that is crushed to a line, or stretched so far that squares leave float's range, has no normal: n
      // goes to 0, and the rest of R pulls along the sides. With the same J in t this has no torque.
      const Vector3<S> u = or_zero(whole & (F2 < S(1e16)), cross(f[0], f[1]));
      const S J = max(sqrt(dot(u, u)), select(whole, F2 * S(1e-6), one));
      const Vector3<S> n = u * (one / J);
      per_t = select(whole, one / sqrt(select(whole, F2 + J + J, one)), zero);
      r[0] = (f[0] + cross(f[1], n)) * per_t, r[1] = (f[1] + cross(n, f[0])) * per_t;
    }
  };

  /// The strains of F, and their derivatives.
  template <class S>
  struct Strained {
    Vector3<S> r[2];  // columns of R
    S a, b, c;
    S per_t, turn, to1, to2;  // 2 S12 / t, 2 S22 / t, 2 S11 / t: effect of the rotation of R on b and c

    template <class Mask>
    KERNEL Strained(const Vector3<S> (&f)[2], const Mask& valid) {
      const S two(2);
      const Turned<S> at(f, valid);
      r[0] = at.r[0], r[1] = at.r[1];
      const S S11 = dot(r[0], f[0]), S12 = dot(r[0], f[1]), S22 = dot(r[1], f[1]), two_per_t = two * at.per_t;
      a = S11 + S22 - two, b = S11 - S22, c = S12 + S12;
      per_t = at.per_t, turn = S12 * two_per_t, to1 = S22 * two_per_t, to2 = S11 * two_per_t;
    }

    /// Computes of_a da/dF + of_b db/dF + of_c dc/dF. R rotates by (r2 . df1 - r1 . df2) / t: da = r1 . df1 + r2 . df2,
    /// db = (r1 + turn r2) . df1 - (r2 + turn r1) . df2, dc = to1 r2 . df1 + to2 r1 . df2.
    KERNEL void pull(const S& of_a, const S& of_b, const S& of_c, Vector3<S> (&g)[2]) const {
      const S tb = turn * of_b;
      g[0] = r[0] * (of_a + of_b) + r[1] * (tb + to1 * of_c), g[1] = r[0] * (to2 * of_c - tb) + r[1] * (of_a - of_b);
    }
  };

  template <class S>
  struct Deformed {
    /// Response of F to forces, dF = B dU/dF: sum w over the gradients of its columns.
    struct Masses {
      S B11, B12, B22;
      KERNEL Masses(const S (&q)[3], const S (&w)[3]) {
        const S q12 = q[1] + q[2], w0q = w[0] * q[0];
        B11 = (w0q + w[1] * q[0]) * q[0], B12 = w0q * q12 + w[1] * q[0] * q[1];
        B22 = w[0] * q12 * q12 + w[1] * q[1] * q[1] + w[2] * q[2] * q[2];
      }
    };
    S q[3];  // rest values
    Law<S> law;
    Strained<S> at;
    S C[3];

    template <class Mask>
    KERNEL Deformed(const Vector3<S> (&p)[3], const S* rest, const Mask& valid)
        : q{select(valid, rest[0], S(0)), select(valid, rest[1], S(0)), select(valid, rest[2], S(0))},
          law{of_valid(rest + 3, valid)},
          at(columns(or_zero(valid, p[1] - p[0]), or_zero(valid, p[2] - p[0]), q).f, valid) {
      law.constraints(at.a, at.b, at.c, C);
    }

    /// Computes sum of part_m grad C_m.
    KERNEL void pull(const S (&part)[3], Vector3<S> (&grad)[3]) const {
      S a, b, c;
      Vector3<S> g[2];
      law.pull(part, a, b, c), at.pull(a, b, c, g);
      grad[1] = g[0] * q[0] + g[1] * q[1];
      grad[2] = g[1] * q[2];
      grad[0] = -(grad[1] + grad[2]);
    }

    /// The angle by which a step rotates R, to first order.
    KERNEL S turning(const Masses& of, const S (&part)[3]) const {
      S a, b, c;
      law.pull(part, a, b, c);
      const S tb = at.turn * b;
      return at.per_t * (of.B11 * (tb + at.to1 * c) + of.B12 * ((a - b) - (a + b)) - of.B22 * (at.to2 * c - tb));
    }

    /// The lower triangle of A = grad C w grad C^T, for orthogonal r1 and r2. (Where n goes to 0 they are not
    /// orthogonal, and this is larger than A.)
    KERNEL void response(const Masses& of, S (&A)[3][3]) const {
      const S B11 = of.B11, B12 = of.B12, B22 = of.B22, sum = B11 + B22, two_B12 = B12 + B12;
      const S turn = at.turn, to1 = at.to1, to2 = at.to2;
      A[0][0] = sum;
      A[1][0] = B11 - B22;
      A[2][0] = two_B12;
      A[1][1] = sum + turn * (turn * sum - (two_B12 + two_B12));
      A[2][1] = turn * (to1 * B11 - to2 * B22) + B12 * (to2 - to1);
      A[2][2] = to1 * to1 * B11 + to2 * to2 * B22;
      law.surround(A);
    }

   private:
    struct Columns {
      Vector3<S> f[2];
    };
    KERNEL static Columns columns(const Vector3<S>& e, const Vector3<S>& g, const S (&q)[3]) {
      return {{e * q[0], e * q[1] + g * q[2]}};
    }
    template <class Mask>
    KERNEL static Law<S> of_valid(const S* numbers, const Mask& valid) {
      Law<S> law;
      for (int i = 0; i < Law<S>::numbers; ++i) law.k[i] = select(valid, numbers[i], S(0));
      return law;
    }
  };
};

struct Membrane : MembraneOf<IsotropicLaw> {
  static constexpr const char* name = "membrane";

  /// Q, and k_a and k_b, m.
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[3], S nu, S (&rest)[5]) {
    const S one(1), part = rest_edges(X, rest);
    rest[3] = sqrt(part / (one - nu)), rest[4] = sqrt(part / (one + nu));
  }

  /// In the filter both columns of F times sqrt(A w / Y) are springs of the stiffness w = Y / (1 - nu), the largest of
  /// the material. With the targets F - P/w, P = dU/dF / A, their force is that of the material.
  struct Stencil {
    static constexpr int vectors = 2, coefficients = 2;
    /// own: sqrt(A w / Y), m, and nu / (1 + nu).
    template <class S>
    KERNEL static void weights(const Vector3<S> (&X)[3], S nu, S (&c)[2][3], S (&own)[2]) {
      S of[5];
      rest(X, nu, of);
      const S size = of[3] * sqrt(S(2));
      c[0][1] = of[0] * size, c[0][2] = S(0);
      c[1][1] = of[1] * size, c[1][2] = of[2] * size;
      for (S(&f)[3] : c) f[0] = -(f[1] + f[2]);
      own[0] = size, own[1] = size > S(0) ? nu / (S(1) + nu) : S(0);
    }
    template <class S>
    KERNEL static void target(const Vector3<S> (&f)[2], const S* own, Vector3<S> (&d)[2]) {
      const S one(1);
      const auto whole = own[0] > S(0);
      const S per_size = one / select(whole, own[0], one);
      const Turned<S> at({f[0] * per_size, f[1] * per_size}, whole);
      const S T11 = dot(at.r[0], f[0]), T12 = dot(at.r[0], f[1]), T22 = dot(at.r[1], f[1]);
      const S of_S = one - (own[1] + own[1]), of_1 = own[1] * (T11 + T22) - own[0];
      d[0] = f[0] - at.r[0] * (of_S * T11 + of_1) - at.r[1] * (of_S * T12);
      d[1] = f[1] - at.r[0] * (of_S * T12) - at.r[1] * (of_S * T22 + of_1);
    }
  };
};

}  // namespace malha
