// SPDX-License-Identifier: Apache-2.0
// What Desbrun's filter sees of a constraint that is more than a spring: vectors f_m = sum_j c_mj x_j, linear in the
// positions of its particles, each drawn to a target d_m(f) with the force -(f_m - d_m) / alpha. The linear part goes
// into the filter's matrix; the targets are taken from where the particles are, as springs take their directions.
// (One local step of Liu, Bargteil, O'Brien, Kavan 2013, for other elements than springs.)
//
// A kind with Filtered::Stencil has a type Stencil with
//   vectors, numbers                how many f_m, and how many numbers the targets need
//   weights(X, parameter, c, own)   c from the rest positions, and those numbers; where all of them are 0, so is d
//   target(f, own, d)
//   lever(X)                        m a unit of C: what turns a stiffness in N/m to one of C. Of free kinds only
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// The constraints of one kind that have targets.
template <class R>
struct TargetView {
  const int* particle;  // kIndexScale times those of each, one constraint after the other
  const R* weight;      // c of each, a vector after the other
  const R* own;
  const R* stiffness;  // 1 / alpha of each
  Vec4<R>* rows;       // d / alpha of each, to be filled
};

/// rows = d / alpha, of the particles at `at`.
template <class R, class Stencil, int n>
struct FindTargets {
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
    Stencil::target(f, targets.own + s * Stencil::numbers, d);
    for (int k = 0; k < m; ++k) targets.rows[s * m + k].set(d[k] * targets.stiffness[s]);
  }
};

/// What pulls at each particle, in packs of 16 as springs: in each slot a row of the targets and its weight.
template <class R>
struct PullView {
  const int* begin;  // of each pack's slots, and one more
  const int* row;    // 16 a slot, times kIndexScale
  const R* weight;   // 16 a slot; 0 in those that a particle does not need
  Vec4<R>* rows;
};

}  // namespace malha
