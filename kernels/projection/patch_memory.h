// SPDX-License-Identifier: Apache-2.0
// The fast memory of a patch, laid out in one of two ways: as a structure of arrays where packs load consecutive
// particles, or as rows (two Vec4 per particle) where they gather particles from anywhere. It has the position of each
// particle at the start of the substep, relative to an origin near its body, its inverse mass, and its displacement
// since: constraints are computed from differences that rounding leaves nearly exact.
#pragma once
#include "kernels/projection/patch.h"
#include "kernels/simd/particles.h"
#include "kernels/simd/rows.h"

namespace malha {

/// One particle, or a pack of them.
template <class T>
struct PatchParticle {
  Vector3<T> x;  // m, position at the start of the substep
  Vector3<T> d;  // m, displacement since
  T w;           // 1/kg
};

/// Size of a particle in fast memory, numbers.
inline constexpr int kNumbersPerParticle = 8;

/// The structure of arrays. In both views T is R for one particle, or Lane<R> for the pack of particles at, at + 1, ...
/// Packs of arbitrary particles are gathered from both views, and scattered to rows only: the few that a structure of
/// arrays has are stored one by one.
template <class R>
struct SoaView {
  static constexpr bool is_soa = true;
  R *x, *y, *z, *w, *dx, *dy, *dz;
  /// The first `slots` numbers of `memory` are x, and so on.
  KERNEL static SoaView over(R* memory, int slots) {
    return {memory,
            memory + slots,
            memory + 2 * slots,
            memory + 3 * slots,
            memory + 4 * slots,
            memory + 5 * slots,
            memory + 6 * slots};
  }
  KERNEL Points<R> positions() const { return {x, y, z}; }
  KERNEL Points<R> displacements() const { return {dx, dy, dz}; }
  KERNEL SoaView from(int at) const { return {x + at, y + at, z + at, w + at, dx + at, dy + at, dz + at}; }

  template <class T>
  KERNEL void store_particle(int at, const PatchParticle<T>& q) const {
    store_points(positions(), at, q.x), store(q.w, w + at), store_displacement(at, q.d);
  }
  template <class T>
  KERNEL void load_particle(int at, PatchParticle<T>& q) const {
    q.x = load_points<T>(positions(), at), load(w + at, q.w), q.d = load_displacement<T>(at);
  }
  template <class T>
  KERNEL Vector3<T> load_displacement(int at) const {
    return load_points<T>(displacements(), at);
  }
  template <class T>
  KERNEL void store_displacement(int at, const Vector3<T>& d) const {
    store_points(displacements(), at, d);
  }
  /// `more`: Vector3 or Vec4.
  template <class Mean>
  KERNEL void add_displacement(int at, const Mean& more) const {
    add_points(displacements(), at, more);
  }
  template <class S>
  KERNEL void gather(const LocalIndex* index, PatchParticle<S>& q) const {
    for (int i = 0; i < int(sizeof(S) / sizeof(R)); ++i) {
      const int at = index[i] / kIndexScale<R>;
      set_lane(q.x.x, i, x[at]), set_lane(q.x.y, i, y[at]), set_lane(q.x.z, i, z[at]), set_lane(q.w, i, w[at]);
      set_lane(q.d.x, i, dx[at]), set_lane(q.d.y, i, dy[at]), set_lane(q.d.z, i, dz[at]);
    }
  }
};

/// Rows.
template <class R>
struct AosView {
  static constexpr bool is_soa = false;
  Vec4<R>*row, *d;
  KERNEL static AosView over(R* memory, int slots) {
    Vec4<R>* const rows = reinterpret_cast<Vec4<R>*>(memory);
    return {rows, rows + slots};
  }
  KERNEL ScatteredPoints<R> positions() const { return {row}; }
  KERNEL ScatteredPoints<R> displacements() const { return {d}; }

  template <class T>
  KERNEL void store_particle(int at, const PatchParticle<T>& q) const {
    scatter_rows(row + at, Consecutive().index, q.x, q.w);
    store_displacement(at, q.d);
  }
  template <class T>
  KERNEL void load_particle(int at, PatchParticle<T>& q) const {
    gather_rows(row + at, Consecutive().index, q.x, q.w);
    q.d = load_displacement<T>(at);
  }
  template <class T>
  KERNEL Vector3<T> load_displacement(int at) const {
    Vector3<T> q;
    T none;
    gather_rows(d + at, Consecutive().index, q, none);
    return q;
  }
  template <class T>
  KERNEL void store_displacement(int at, const Vector3<T>& q) const {
    scatter_rows(d + at, Consecutive().index, q, T(R(0)));
  }
  template <class T>
  KERNEL void add_displacement(int at, const Vector3<T>& more) const {
    store_displacement(at, load_displacement<T>(at) + more);
  }
  /// more.w is 0.
  KERNEL void add_displacement(int at, const Vec4<R>& more) const { add_row(d[at], more, R(1)); }
  template <class S>
  KERNEL void gather(const LocalIndex* index, PatchParticle<S>& q) const {
    S none;
    gather_rows(row, index, q.x, q.w);
    gather_rows(d, index, q.d, none);
  }
  template <class S>
  KERNEL void scatter(const LocalIndex* index, const Vector3<S>& displacement) const {
    scatter_rows(d, index, displacement, S(0));
  }

 private:
  struct Consecutive {
    LocalIndex index[16];
    KERNEL Consecutive() {
      for (int i = 0; i < 16; ++i) index[i] = LocalIndex(i * kIndexScale<R>);
    }
  };
};

/// Calls work(view) with the view that a patch has of its memory.
template <class R, class Work>
KERNEL void with_patch_memory(const Patch& patch, void* memory, const Work& work) {
  if (patch.columns)
    work(SoaView<R>::over(static_cast<R*>(memory), patch.slots));
  else
    work(AosView<R>::over(static_cast<R*>(memory), patch.slots));
}

}  // namespace malha
