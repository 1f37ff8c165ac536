// SPDX-License-Identifier: Apache-2.0
// Simultaneous projection of several constraints on the same particles: XPBD's step (Macklin, Müller, Chentanez 2016,
// eq. 18) with a small matrix in place of its one denominator. Projected one after the other they would undo each
// other's corrections.
#pragma once
#include "kernels/projection/direction.h"

namespace malha {

/// Solves A x = b for a symmetric positive definite A, of which the lower triangle is read, by L D L^T without pivots.
template <class S, int m>
KERNEL void solve_block(S (&A)[m][m], const S (&b)[m], S (&x)[m]) {
  const S one(1);
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

/// Solves (A + alpha) dlambda = -C - alpha sum, A = grad w grad^T. Of A the lower triangle is read, and overwritten.
/// dlambda is 0 where nothing can move (no gradient, all pinned, or A beyond the type's range) and where not `valid`.
template <class S, int m, class Mask>
KERNEL void solve_at_once(S (&A)[m][m], const S (&C)[m], S alpha, const S (&sum)[m], const Mask& valid,
                          S (&dlambda)[m]) {
  using R = typename RealOf<S>::type;
  const S zero(0), one(1);
  S trace = A[0][0], b[m];
  for (int i = 1; i < m; ++i) trace = trace + A[i][i];
  const auto moves = valid & (trace > S(tiny<S>())) & (trace < S(R(1) / tiny<R>()));
  // The system is divided by the trace, so that products stay in range. Without compliance, linearly dependent
  // gradients make A singular: a millionth on the diagonal keeps pivots above rounding.
  const S per_trace = one / select(moves, trace, one), softness = max(alpha * per_trace, S(1e-6));
  for (int i = 0; i < m; ++i) {
    for (int k = 0; k < i; ++k) A[i][k] = select(moves, A[i][k] * per_trace, zero);
    A[i][i] = select(moves, A[i][i] * per_trace + softness, one);
    b[i] = select(moves, (-C[i] - alpha * sum[i]) * per_trace, zero);
  }
  solve_block(A, b, dlambda);
}

}  // namespace malha
