// SPDX-License-Identifier: Apache-2.0
// plate: bending of an isotropic plate of rigidity D (N m) and Poisson's ratio nu on any triangles. A triangle of area
// A and the three about it, folded by the angles theta at its hinges, have two curvature tensors:
//   H, of the quadratic height that folds them so (the six-point fit of Grinspun, Gingold, Reisman, Zorin, "Computing
//     discrete shape operators on general meshes", 2006), and
//   H' = sum_i 2 theta_i / (h_i + h'_i) n_i n_i^T, with the normals n of the sides and the heights h, h' of the corners
//     over them: the integral about the triangle of the slopes, which are interpolated between its centroid and its
//     neighbours' (as those of the rotation-free plate triangle of Onate, Cervera 1993).
// H is exact where the curvature is constant. But the forces of a constant moment by H do not cancel at the particles
// inside, so that a plate by |H|^2 gives way to a softer shape; those by H' do, but |H'|^2 is too stiff. The energy is
// the product of both, which keeps the energy of a constant curvature and leaves the smaller part of such forces:
//   U = D A / 2 ((1 - nu) H : H' + nu tr H tr H') = D / 2 sum C_m^2,  C = B (theta - theta0),
// three constraints of compliance 1 / D in the angles, projected together. Angles are signed and relative to rest.
#pragma once
#include "kernels/constraints/bending.h"
#include "kernels/projection/block_solve.h"

namespace malha {

struct Plate {
  static constexpr const char* name = "plate";
  static constexpr Element element = Element::WingedTriangles;
  static constexpr int particles = 6;  // the triangle 0 1 2, and wing 3 + i beyond the side opposite to corner i
  static constexpr bool inequality = false;
  static constexpr Strength strength{false, "rigidity", "N m"};
  static constexpr Filtered filtered = Filtered::Stencil;
  static constexpr int rest_values = 13;  // the three angles at rest, B, and 1 / max step
  static constexpr int per_max_step = 12;
  static constexpr int multipliers = 3;
  static constexpr Parameter parameter{"poisson_ratio", 0, 0, true,
                                       0.99};  // at 1 twist and saddle shapes store no energy
  using Remainder = Bending;                   // for hinges that no element has

  KERNEL static double compliance(double D, double) { return 1 / D; }

  /// The six points unfolded about the triangle: its corner 0 at (0, 0), its corner 1 at (length, 0).
  template <class S>
  KERNEL static void unfold(const Vector3<S> (&X)[6], S (&u)[6], S (&v)[6]) {
    const S zero(0), one(1);
    const Vector3<S> e = X[1] - X[0], f = X[2] - X[0], n = cross(e, f);
    const S length = sqrt(dot(e, e)), twice = sqrt(dot(n, n));
    const S per_length = one / select(length > zero, length, one);
    u[0] = zero, u[1] = length, u[2] = dot(e, f) * per_length;
    v[0] = zero, v[1] = zero, v[2] = twice * per_length;
    for (int i = 0; i < 3; ++i) {
      // The wing lies beyond the side, at its height.
      const int from = (i + 1) % 3, to = (i + 2) % 3, wing = 3 + i;
      const S du = u[to] - u[from], dv = v[to] - v[from], side = sqrt(du * du + dv * dv);
      const S per_side = one / select(side > zero, side, one);
      S foot, height;
      over_edge(X[from], X[to], X[wing], foot, height);
      u[wing] = u[from] + du * foot + dv * per_side * height, v[wing] = v[from] + dv * foot - du * per_side * height;
    }
  }

  /// The matrix of theta = a (Hxx, Hyy, Hxy) over the mesh unfolded about the triangle to u and v, m; `area` of the
  /// triangle, m^2.
  template <class S>
  KERNEL static void folds_by_curvature(const Vector3<S> (&X)[6], S (&u)[6], S (&v)[6], S (&a)[3][3], S& area) {
    const S zero(0), half(0.5);
    unfold(X, u, v);
    const Vector3<S> n = cross(X[1] - X[0], X[2] - X[0]);
    area = sqrt(dot(n, n)) * half;
    for (int i = 0; i < 3; ++i) {
      S c[6];
      fold_weights(X, i, c);
      const int from = (i + 1) % 3, to = (i + 2) % 3, wing = 3 + i;
      a[i][0] = a[i][1] = a[i][2] = zero;
      const int corners[4] = {from, to, i, wing};
      for (const int j : corners) {
        a[i][0] = a[i][0] + c[j] * half * u[j] * u[j], a[i][1] = a[i][1] + c[j] * half * v[j] * v[j];
        a[i][2] = a[i][2] + c[j] * u[j] * v[j];
      }
    }
  }

  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[6], S nu, S (&rest)[rest_values]) {
    rest_by<IsotropicLaw<S>>(X, nu, rest);
  }

  /// Rest values by the law of a material: a class whose energy of a curvature z = (Hxx + Hyy, Hxx - Hyy, 2 Hxy) over D
  /// is half the square of law(z).
  template <class Law, class S, class Material>
  KERNEL static void rest_by(const Vector3<S> (&X)[6], const Material& material, S (&rest)[rest_values]) {
    const S zero(0), one(1);
    S u[6], v[6], a[3][3], area;
    folds_by_curvature(X, u, v, a, area);
    const Vector3<S> row[3] = {{a[0][0], a[0][1], a[0][2]}, {a[1][0], a[1][1], a[1][2]}, {a[2][0], a[2][1], a[2][2]}};
    const Vector3<S> column[3] = {cross(row[1], row[2]), cross(row[2], row[0]), cross(row[0], row[1])};
    const S det = dot(row[0], column[0]), size = area * sqrt(area);
    const auto fits = (det * det > size * size * S(1e-12)) & (area > zero);
    const S per_det = one / select(fits, det, one);
    const Law law(X, area, material);
    S R[3][3];
    factor_of_product(u, v, a, law, fits, R);
    S smallest = zero;             // of the heights over the hinges
    for (int i = 0; i < 3; ++i) {  // H = a^-1 theta, whose columns are column[i] / det
      const Vector3<S> H = or_zero(fits, column[i] * per_det);
      const S z[3] = {H.x + H.y, H.x - H.y, H.z + H.z};
      S y[3];
      law.apply(z, y);
      rest[3 + i] = R[0][0] * y[0] + R[0][1] * y[1] + R[0][2] * y[2];
      rest[6 + i] = R[1][1] * y[1] + R[1][2] * y[2], rest[9 + i] = R[2][2] * y[2];
      Vector3<S> q[4], grad[4];
      S scale, none[1] = {zero};
      hinge(X, i, q);
      rest[i] = select(fits, Bending::evaluate(q, none, fits, grad, scale), zero);
      for (int corner = i; corner < 6; corner += 3) {
        S foot, height;
        over_edge(X[(i + 1) % 3], X[(i + 2) % 3], X[corner], foot, height);
        smallest = i == 0 && corner == 0 ? height : select(height < smallest, height, smallest);
      }
    }
    rest[per_max_step] = per_max_step_of(smallest);
  }

  /// C = sqrt(sum C_m^2) = sqrt(2 U / D); where all are 0 the gradient is that of the first.
  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[6], const S* rest, const Mask& valid, Vector3<S> (&grad)[6],
                           S& scale) {
    const S zero(0), one(1);
    const Folds<S> now(p, rest, valid);
    S C[3], squares = zero;
    now.constraints(rest, valid, C);
    for (const S& c : C) squares = squares + c * c;
    const S length = sqrt(squares);
    const auto off = length > S(tiny<S>());
    for (int m = 0; m < 3; ++m) C[m] = select(off, C[m] / select(off, length, one), m == 0 ? one : zero);
    S pull[3];
    now.pulls(rest, valid, C, pull);
    now.gather(pull, grad);
    S size = zero;
    for (const auto& g : grad) size = size + dot(g, g);
    scale = select(size > zero, one, zero);
    return length;
  }

  /// The energy over D.
  KERNEL static double energy(const Vector3<double> (&p)[6], const double* rest) {
    Vector3<double> grad[6];
    double scale;
    const double C = evaluate(p, rest, true, grad, scale);
    return C * C / 2;
  }

  /// XPBD's step of all three together, in the angles, which are fewer than the positions. The step is bounded as that
  /// of `bending`.
  template <class S, class Mask>
  KERNEL static void step(const Vector3<S> (&p)[6], const Vector3<S> (&x)[6], const S (&w)[6], const S* rest,
                          const Mask& valid, S alpha, S max_start_step, S (&sum)[3], Vector3<S> (&move)[6]) {
    const Folds<S> now(p, rest, valid);
    S C[3], turn[3][3], A[3][3], dlambda[3];
    now.constraints(rest, valid, C);
    now.response(w, turn);
    for (int m = 0; m < 3; ++m) {
      S row[3];  // of B turn
      for (int k = 0; k < 3; ++k) {
        row[k] = coefficient(rest, valid, m, 0) * turn[0][k];
        for (int i = 1; i < 3; ++i) row[k] = row[k] + coefficient(rest, valid, m, i) * turn[i][k];
      }
      for (int k = 0; k <= m; ++k) {
        A[m][k] = row[0] * coefficient(rest, valid, k, 0);
        for (int i = 1; i < 3; ++i) A[m][k] = A[m][k] + row[i] * coefficient(rest, valid, k, i);
      }
    }
    solve_at_once(A, C, alpha, sum, valid, dlambda);
    S pull[3], pull_of_all[3], all[3], step2 = S(0);
    for (int m = 0; m < 3; ++m) all[m] = sum[m] + dlambda[m];
    now.pulls(rest, valid, dlambda, pull), now.pulls(rest, valid, all, pull_of_all);
    now.gather(pull, move);
    Vector3<S> along[6], carried[6];
    const Folds<S> then(x, rest, valid);
    then.gather(pull, along), then.gather(pull_of_all, carried);
    blend_with_start(max_start_step, relative_displacement2(w, carried, x), w, along, move);
    for (int j = 0; j < 6; ++j) step2 = max(step2, w[j] * w[j] * dot(move[j], move[j]));
    const S one(1), part = one / max(sqrt(step2) * select(valid, rest[per_max_step], one), one);
    for (int m = 0; m < 3; ++m) sum[m] = sum[m] + dlambda[m] * part;
    for (auto& of : move) of = of * part;
  }

  /// In the filter the three are vectors, B times the fold vectors of the hinges, each pulled to its length at rest.
  struct Stencil {
    static constexpr int vectors = 3, coefficients = 21;  // B, its inverse, signed lengths of the folds at rest
    template <class S>
    KERNEL static void weights(const Vector3<S> (&X)[6], S nu, S (&c)[3][6], S (&own)[21]) {
      S of[Plate::rest_values];
      rest(X, nu, of);
      weights_of(X, of, c, own);
    }
    /// The same by the rest values.
    template <class S>
    KERNEL static void weights_of(const Vector3<S> (&X)[6], const S (&of)[Plate::rest_values], S (&c)[3][6],
                                  S (&own)[21]) {
      const S zero(0), one(1);
      S fold[3][6], folded = zero;
      for (int i = 0; i < 3; ++i) {
        fold_weights(X, i, fold[i]);
        Vector3<S> f{zero, zero, zero};
        for (int j = 0; j < 6; ++j) f = f + X[j] * fold[i][j];
        Vector3<S> q[4];
        hinge(X, i, q);
        const S length = sqrt(dot(f, f));
        own[18 + i] = select(dot(f, IsometricBending::normal_of(q)) < zero, -length, length);
        folded = max(folded, length);
      }
      for (int m = 0; m < 3; ++m)
        for (int j = 0; j < 6; ++j)
          c[m][j] = of[3 + 3 * m] * fold[0][j] + of[4 + 3 * m] * fold[1][j] + of[5 + 3 * m] * fold[2][j];
      const Vector3<S> row[3] = {{of[3], of[4], of[5]}, {of[6], of[7], of[8]}, {of[9], of[10], of[11]}};
      const Vector3<S> column[3] = {cross(row[1], row[2]), cross(row[2], row[0]), cross(row[0], row[1])};
      const S det = dot(row[0], column[0]);
      const auto curved = (folded > S(1e-9)) & (det * det > zero);
      const S per_det = one / select(curved, det, one);
      for (int k = 0; k < 9; ++k) own[k] = of[3 + k];
      for (int m = 0; m < 3; ++m)
        own[9 + m] = column[m].x * per_det, own[12 + m] = column[m].y * per_det, own[15 + m] = column[m].z * per_det;
      for (S& number : own) number = select(curved, number, zero);
    }
    template <class S>
    KERNEL static void target(const Vector3<S> (&f)[3], const S* own, Vector3<S> (&d)[3]) {
      Vector3<S> fold[1], at[3][1];
      for (int i = 0; i < 3; ++i) {
        fold[0] = f[0] * own[9 + 3 * i] + f[1] * own[10 + 3 * i] + f[2] * own[11 + 3 * i];
        IsometricBending::Stencil::target(fold, own + 18 + i, at[i]);
      }
      gather(at[0][0], at[1][0], at[2][0], own, d);
    }
    template <class S>
    KERNEL static void target_by_normals(const Vector3<S> (&x)[6], const S* own, Vector3<S> (&d)[3]) {
      Vector3<S> at[3];
      for (int i = 0; i < 3; ++i) {
        Vector3<S> q[4];
        hinge(x, i, q);
        at[i] = IsometricBending::normal_of(q) * own[18 + i];
      }
      gather(at[0], at[1], at[2], own, d);
    }

   private:
    /// Computes d = B at.
    template <class S>
    KERNEL static void gather(const Vector3<S>& at0, const Vector3<S>& at1, const Vector3<S>& at2, const S* own,
                              Vector3<S> (&d)[3]) {
      for (int m = 0; m < 3; ++m) d[m] = at0 * own[3 * m] + at1 * own[3 * m + 1] + at2 * own[3 * m + 2];
    }
  };

 private:
  /// The law of isotropic material.
  template <class S>
  struct IsotropicLaw {
    S sum, difference, ratio;
    KERNEL IsotropicLaw(const Vector3<S> (&)[6], S area, S nu) {
      const S one(1), half(0.5);
      sum = sqrt(area * (one + nu) * half), difference = sqrt(area * (one - nu) * half);
      ratio = sqrt((one - nu) / (one + nu));
    }
    KERNEL void apply(const S (&z)[3], S (&y)[3]) const {
      y[0] = sum * z[0], y[1] = difference * z[1], y[2] = difference * z[2];
    }
    /// Computes y over `sum`, and a row of numbers per z as one per that.
    KERNEL void apply_scaled(const S (&z)[3], S (&y)[3]) const {
      y[0] = z[0], y[1] = z[1] * ratio, y[2] = z[2] * ratio;
    }
    KERNEL void row_scaled(const S (&per_z)[3], S (&per_y)[3]) const {
      per_y[0] = per_z[0], per_y[1] = per_z[1] / ratio, per_y[2] = per_z[2] / ratio;
    }
  };

  /// R with R^T R = (G + G^T) / 2, where G turns H into H', both in the coordinates law(H), whose squares are twice the
  /// energy over D by H alone.
  template <class S, class Law, class Mask>
  KERNEL static void factor_of_product(const S (&u)[6], const S (&v)[6], const S (&a)[3][3], const Law& law,
                                       const Mask& fits, S (&R)[3][3]) {
    // Some triangles (1 to 4 % of Delaunay's, a fifth of those with diagonals at random) have so different curvatures
    // that their product could be negative. It is mixed with |H|^2 there, so that no curvature has less than this share
    // of the energy by H alone.
    constexpr double least = 0.2;
    const S zero(0), one(1), half(0.5);
    S change[3][3] = {{-one, zero, zero}, {zero, -one, zero}, {zero, zero, -one}};  // (G + G^T) / 2 - 1
    for (int i = 0; i < 3; ++i) {
      const int from = (i + 1) % 3, to = (i + 2) % 3, wing = 3 + i;
      const S x = v[to] - v[from], y = u[from] - u[to];  // l n
      const S across = (u[wing] - u[i]) * x + (v[wing] - v[i]) * y, size = across * sqrt(x * x + y * y);
      const S per = select(fits, S(2) / select(fits, size, one), zero);
      const S z[3] = {(x * x + y * y) * per, (x * x - y * y) * per, (x + x) * y * per};
      const S per_z[3] = {(a[i][0] + a[i][1]) * half, (a[i][0] - a[i][1]) * half, a[i][2] * half};
      S weak[3], fold[3];
      law.apply_scaled(z, weak), law.row_scaled(per_z, fold);
      for (int m = 0; m < 3; ++m)
        for (int k = 0; k < 3; ++k) change[m][k] = change[m][k] + (weak[m] * fold[k] + weak[k] * fold[m]) * half;
    }
    // The least eigenvalue of a symmetric matrix is at least its mean less sqrt(2/3) the norm of its deviator.
    const S mean = (change[0][0] + change[1][1] + change[2][2]) * S(1.0 / 3);
    S deviator2 = zero;
    for (int m = 0; m < 3; ++m)
      for (int k = 0; k < 3; ++k) {
        const S of = m == k ? change[m][k] - mean : change[m][k];
        deviator2 = deviator2 + of * of;
      }
    const S most(1 - least), loss = sqrt(deviator2 * S(2.0 / 3)) - mean, part = most / max(loss, most);
    S Q[3][3];
    for (int m = 0; m < 3; ++m)
      for (int k = 0; k < 3; ++k) Q[m][k] = (m == k ? one : zero) + select(fits, change[m][k] * part, zero);
    for (int m = 0; m < 3; ++m)
      for (int k = 0; k < 3; ++k) {
        R[m][k] = k < m ? zero : Q[m][k];
        for (int j = 0; j < m && k >= m; ++j) R[m][k] = R[m][k] - R[j][m] * R[j][k];
        R[m][k] = k < m ? zero : k == m ? sqrt(R[m][k]) : R[m][k] / R[m][m];
      }
  }

  /// The foot of a wing on an edge, as a part of the edge, and its height over it.
  template <class S>
  KERNEL static void over_edge(const Vector3<S>& from, const Vector3<S>& to, const Vector3<S>& wing, S& foot,
                               S& height) {
    const S one(1);
    const Vector3<S> e = to - from, r = wing - from, n = cross(e, r);
    const S e2 = dot(e, e), per_e2 = one / select(e2 > S(tiny<S>()), e2, one);
    foot = dot(r, e) * per_e2, height = sqrt(dot(n, n) * per_e2);
  }

  /// Weights of the hinge opposite to corner i: its fold is sum c_j x_j (see IsometricBending), 0 for one without
  /// height.
  template <class S>
  KERNEL static void fold_weights(const Vector3<S> (&X)[6], int i, S (&c)[6]) {
    const S zero(0), one(1);
    for (S& of : c) of = zero;
    const int from = (i + 1) % 3, to = (i + 2) % 3;
    const int wings[2] = {i, 3 + i};
    for (const int wing : wings) {
      S foot, height;
      over_edge(X[from], X[to], X[wing], foot, height);
      const S per_height = select(height > zero, one / select(height > zero, height, one), zero);
      c[wing] = per_height, c[from] = c[from] - (one - foot) * per_height, c[to] = c[to] - foot * per_height;
    }
  }

  template <class S>
  KERNEL static void hinge(const Vector3<S> (&p)[6], int i, Vector3<S> (&q)[4]) {
    q[0] = p[(i + 1) % 3], q[1] = p[(i + 2) % 3], q[2] = p[i], q[3] = p[3 + i];
  }
  /// A coefficient of B, or 0 in padding.
  template <class S, class Mask>
  KERNEL static S coefficient(const S* rest, const Mask& valid, int m, int i) {
    return select(valid, rest[3 + 3 * m + i], S(0));
  }

  template <class S>
  struct Folds {
    S theta[3];             // from rest
    Vector3<S> grad[3][4];  // of each angle at its hinge's particles

    template <class Mask>
    KERNEL Folds(const Vector3<S> (&p)[6], const S* rest, const Mask& valid) {
      for (int i = 0; i < 3; ++i) {
        Vector3<S> q[4];
        S scale;
        hinge(p, i, q);
        theta[i] = Bending::evaluate(q, rest + i, valid, grad[i], scale);
      }
    }
    template <class Mask>
    KERNEL void constraints(const S* rest, const Mask& valid, S (&C)[3]) const {
      for (int m = 0; m < 3; ++m)
        C[m] = coefficient(rest, valid, m, 0) * theta[0] + coefficient(rest, valid, m, 1) * theta[1] +
               coefficient(rest, valid, m, 2) * theta[2];
    }
    /// Computes B^T x.
    template <class Mask>
    KERNEL void pulls(const S* rest, const Mask& valid, const S (&x)[3], S (&pull)[3]) const {
      for (int i = 0; i < 3; ++i)
        pull[i] = coefficient(rest, valid, 0, i) * x[0] + coefficient(rest, valid, 1, i) * x[1] +
                  coefficient(rest, valid, 2, i) * x[2];
    }
    /// The index, among the six, of particle j of hinge i.
    KERNEL static int particle(int i, int j) {
      return j == 0 ? (i + 1) % 3 : j == 1 ? (i + 2) % 3 : j == 2 ? i : 3 + i;
    }
    /// Computes grad w grad^T of the angles.
    KERNEL void response(const S (&w)[6], S (&turn)[3][3]) const {
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k <= i; ++k) {
          turn[i][k] = S(0);
          for (int j = 0; j < 4; ++j)
            for (int l = 0; l < 4; ++l)
              if (particle(i, j) == particle(k, l))
                turn[i][k] = turn[i][k] + w[particle(i, j)] * dot(grad[i][j], grad[k][l]);
          turn[k][i] = turn[i][k];
        }
    }
    KERNEL void gather(const S (&pull)[3], Vector3<S> (&sum)[6]) const {
      const S zero(0);
      for (auto& of : sum) of = {zero, zero, zero};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) sum[particle(i, j)] = sum[particle(i, j)] + grad[i][j] * pull[i];
    }
  };
};

}  // namespace malha
