// SPDX-License-Identifier: Apache-2.0
// Angular velocity of a body as a whole, from its angular momentum and inertia.
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

/// Angular momentum L (kg m^2/s) and inertia I (kg m^2: xx, yy, zz, xy, xz, yz) about a point.
struct SpinSum {
  double L[3] = {}, I[6] = {};
  KERNEL SpinSum& operator+=(const SpinSum& o) {
    for (int k = 0; k < 3; ++k) L[k] += o.L[k];
    for (int k = 0; k < 6; ++k) I[k] += o.I[k];
    return *this;
  }
};

/// Adds a mass (kg) at r (m) to an inertia.
KERNEL void add_inertia(double (&I)[6], double m, const Vector3<double>& r) {
  I[0] += m * (r.y * r.y + r.z * r.z), I[1] += m * (r.x * r.x + r.z * r.z), I[2] += m * (r.x * r.x + r.y * r.y);
  I[3] -= m * r.x * r.y, I[4] -= m * r.x * r.z, I[5] -= m * r.y * r.z;
}
/// Converts an inertia to one about the centre of mass, which is at c (m; parallel axis theorem).
KERNEL void centre_inertia(double (&I)[6], double mass, const Vector3<double>& c) { add_inertia(I, -mass, c); }

/// Makes A_pq zero by a rotation in both axes, which it applies to V too (Jacobi; Golub and Van Loan, Matrix
/// Computations, 8.5).
KERNEL void rotate_axes(double (&A)[3][3], double (&V)[3][3], int p, int q) {
  if (A[p][q] == 0) return;
  const int r = 3 - p - q;
  const double tau = (A[q][q] - A[p][p]) / (2 * A[p][q]), size = sqrt(1 + tau * tau);
  const double t = tau < 0 ? -1 / (size - tau) : 1 / (size + tau), c = 1 / sqrt(1 + t * t), s = t * c;
  A[p][p] -= t * A[p][q], A[q][q] += t * A[p][q];
  A[p][q] = A[q][p] = 0;
  const double rp = A[r][p], rq = A[r][q];
  A[r][p] = A[p][r] = c * rp - s * rq, A[r][q] = A[q][r] = s * rp + c * rq;
  for (double(&row)[3] : V) {
    const double vp = row[p], vq = row[q];
    row[p] = c * vp - s * vq, row[q] = s * vp + c * vq;
  }
}

/// omega = I^-1 L. A body whose particles lie on one line or point has no inertia about some axis: the least-norm
/// solution leaves that rotation at zero.
KERNEL_NOINLINE Vector3<double> angular_velocity(const SpinSum& spin) {
  const double *I = spin.I, *L = spin.L;
  double A[3][3] = {{I[0], I[3], I[4]}, {I[3], I[1], I[5]}, {I[4], I[5], I[2]}};
  double V[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  constexpr int kSweeps = 8;  // convergence is quadratic: five are enough for double
  KERNEL_ROLLED
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    rotate_axes(A, V, 0, 1), rotate_axes(A, V, 0, 2), rotate_axes(A, V, 1, 2);
  const double largest = max(A[0][0], max(A[1][1], A[2][2]));
  const double smallest = 1e-7 * largest;  // rounding of float positions, with a margin
  Vector3<double> omega{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const Vector3<double> axis{V[0][k], V[1][k], V[2][k]};
    if (A[k][k] > smallest) omega = omega + axis * (dot(axis, Vector3<double>{L[0], L[1], L[2]}) / A[k][k]);
  }
  return omega;
}

}  // namespace malha
