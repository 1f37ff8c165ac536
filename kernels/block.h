// Several constraints on the same particles, met at once: XPBD's step (Macklin, Müller, Chentanez 2016, eq. 18) with a
// small matrix in place of its one denominator. One after the other they would undo each other's work.
#pragma once
#include "kernels/vec.h"

namespace malha {

/// x = A^-1 b of a symmetric positive definite A (its lower triangle is read), by L D L^T without pivots.
template <class S, int m>
KERNEL void solve_block(S (&A)[m][m], const S (&b)[m], S (&x)[m]) {
  const S one(typename RealOf<S>::type(1));
  S per_d[m];
  for (int i = 0; i < m; ++i) {
    for (int k = 0; k < i; ++k) {  // A[i][k] becomes L_ik D_k
      for (int l = 0; l < k; ++l) A[i][k] = A[i][k] - A[i][l] * A[k][l] * per_d[l];
    }
    for (int l = 0; l < i; ++l) A[i][i] = A[i][i] - A[i][l] * A[i][l] * per_d[l];
    per_d[i] = one / A[i][i];
  }
  for (int i = 0; i < m; ++i) {
    x[i] = b[i];
    for (int k = 0; k < i; ++k) x[i] = x[i] - A[i][k] * per_d[k] * x[k];
  }
  for (int i = m - 1; i >= 0; --i) {
    x[i] = x[i] * per_d[i];
    for (int k = i + 1; k < m; ++k) x[i] = x[i] - A[k][i] * per_d[i] * x[k];
  }
}

/// dlambda of (grad w grad^T + alpha) dlambda = -C - alpha lambda, added to `sum` (lambda); `move`: what each particle
/// moves, over its w. Where nothing can move (no gradient, or all pinned) nothing does.
template <class S, int m, int n>
KERNEL void meet_at_once(const S (&w)[n], const S (&C)[m], const Vector3<S> (&grad)[m][n], S alpha, S (&sum)[m],
                         Vector3<S> (&move)[n]) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1));
  S A[m][m], b[m], dlambda[m];
  S trace = zero;
  for (int i = 0; i < m; ++i)
    for (int k = 0; k <= i; ++k) {
      S of = w[0] * dot(grad[i][0], grad[k][0]);
      for (int j = 1; j < n; ++j) of = of + w[j] * dot(grad[i][j], grad[k][j]);
      A[i][k] = of;
      if (i == k) trace = trace + of;
    }
  const auto moves = trace > S(tiny<R>());
  // Without compliance, gradients that depend on one another leave no more than their common part: a millionth of the
  // trace keeps the matrix from being singular.
  const S least = trace * S(R(1e-6));
  for (int i = 0; i < m; ++i) {
    A[i][i] = select(moves, A[i][i] + larger(alpha, least), one);
    for (int k = 0; k < i; ++k) A[i][k] = select(moves, A[i][k], zero);
    b[i] = select(moves, -C[i] - alpha * sum[i], zero);
  }
  solve_block(A, b, dlambda);
  for (int j = 0; j < n; ++j) {
    move[j] = grad[0][j] * dlambda[0];
    for (int i = 1; i < m; ++i) move[j] = move[j] + grad[i][j] * dlambda[i];
  }
  for (int i = 0; i < m; ++i) sum[i] = sum[i] + dlambda[i];
}

}  // namespace malha
