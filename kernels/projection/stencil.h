// SPDX-License-Identifier: Apache-2.0
// Stencils: constraints other than springs in Desbrun's filter. A stencil has vectors f_m = sum_j c_mj x_j, linear in
// the positions of its particles, and pulls each to a target d_m(f) with the force -(f_m - d_m) / alpha. The linear
// part is in the filter's matrix; the targets are computed from the current positions, as the directions of springs.
// (This is one local step of Liu, Bargteil, O'Brien, Kavan 2013, for other elements than springs.)
//
// A kind with Filtered::Stencil has a type Stencil with
//   vectors, coefficients             number of f_m, and of the coefficients of a target
//   weights(X, parameter, c, coeff)   both, from the rest positions; with coefficients of 0 the target is 0
//   target(f, coeff, d)               d_m(f)
//   target_by_normals(x, coeff, d)    d_m from the positions of the particles. Only kinds that PBD filters have it
//   lever(X)                          m per unit of C, which converts a stiffness in N/m to one of C. Only kinds that
//                                     accept a stiffness have it
#pragma once
#include "kernels/simd/rows.h"

namespace malha {

/// The stencils of one kind.
template <class R>
struct TargetView {
  const int* particle;  // particles of each constraint, times kIndexScale
  const R* weight;      // c of each constraint, vector by vector
  const R* coefficients;
  const R* stiffness;  // 1 / alpha of each constraint
  Vec4<R>* rows;       // result: d / alpha, vector by vector
};

/// Computes the targets of stencils from the positions `at`.
template <class R, class Stencil, int n>
struct ComputeTargets {
  TargetView<R> targets;
  Vec4<R>* at;
  KERNEL void operator()(int s) const {
    constexpr int m = Stencil::vectors;
    Vector3<R> f[m], d[m];
    for (int k = 0; k < m; ++k) f[k] = {R(0), R(0), R(0)};
    for (int j = 0; j < n; ++j) {
      Vector3<R> x;
      R none;
      gather_rows(at, targets.particle + s * n + j, x, none);
      for (int k = 0; k < m; ++k) f[k] = f[k] + x * targets.weight[(s * m + k) * n + j];
    }
    Stencil::target(f, targets.coefficients + s * Stencil::coefficients, d);
    for (int k = 0; k < m; ++k) targets.rows[s * m + k].set(d[k] * targets.stiffness[s]);
  }
};

/// Computes the targets of bending along the normals of its hinges at the positions `at`, turned by the rotation of
/// their block, a vector in rad (Cayley's form, which keeps lengths).
template <class R, class Stencil, int n>
struct ComputeTurnedTargets {
  TargetView<R> targets;
  Vec4<R>* at;
  const int* block;  // of each constraint
  const Vec4<R>* rotations;
  KERNEL void operator()(int s) const {
    constexpr int m = Stencil::vectors;
    Vector3<R> x[n], d[m];
    for (int j = 0; j < n; ++j) {
      R none;
      gather_rows(at, targets.particle + s * n + j, x[j], none);
    }
    Stencil::target_by_normals(x, targets.coefficients + s * Stencil::coefficients, d);
    const Vector3<R> a = rotations[block[s]].xyz() * R(0.5);
    const R part = R(2) / (R(1) + dot(a, a));
    for (int k = 0; k < m; ++k) {
      const Vector3<R> turned = cross(a, d[k]);
      targets.rows[s * m + k].set((d[k] + (turned + cross(a, turned)) * part) * targets.stiffness[s]);
    }
  }
};

/// The targets that act on each particle, in packs of 16 particles like springs: a slot has a row of the targets and
/// its weight.
template <class R>
struct PullView {
  const int* begin;  // first slot of each pack, and the number of slots
  const int* row;    // 16 per slot, times kIndexScale
  const R* weight;   // 16 per slot; 0 in unused slots of a particle
  Vec4<R>* rows;
};

}  // namespace malha
