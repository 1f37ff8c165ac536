// SPDX-License-Identifier: Apache-2.0
// The fast memory of a patch, laid out in one of two ways: columns (an array a coordinate) where packs read particles
// that lie side by side, rows (two Vec4 a particle) where they gather them from anywhere. Of each particle it has where
// the substep began, from an origin near its body, its inverse mass, and how far it has gone since: constraints are
// computed from differences that rounding leaves nearly exact.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// One particle, or a pack of them.
template <class T>
struct Moving {
  Vector3<T> x;  // m, where the substep began
  Vector3<T> d;  // m, the way since
  T w;           // 1/kg
};

/// Numbers of fast memory that a particle takes.
inline constexpr int kLocalNumbers = 8;

/// What both offer. T is R for one particle or Lane<R> for the pack of particles at, at + 1, ...
/// fill, read: all of a particle; write, add: its way. Packs of any particles are gathered from both; they are
/// scattered to rows only: the few in columns are written one by one.
template <class R>
struct SoaView {
  static constexpr bool side_by_side = true;
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
  /// The ways in place of where they are.
  KERNEL SoaView ways() const { return {dx, dy, dz, nullptr, nullptr, nullptr, nullptr}; }
  KERNEL SoaView from(int at) const { return {x + at, y + at, z + at, w + at, dx + at, dy + at, dz + at}; }

  template <class T>
  KERNEL void fill(int at, const Moving<T>& q) const {
    store(q.x.x, x + at), store(q.x.y, y + at), store(q.x.z, z + at), store(q.w, w + at);
    write(at, q.d);
  }
  template <class T>
  KERNEL void read(int at, Moving<T>& q) const {
    load(x + at, q.x.x), load(y + at, q.x.y), load(z + at, q.x.z), load(w + at, q.w);
    q.d = way<T>(at);
  }
  template <class T>
  KERNEL Vector3<T> way(int at) const {
    Vector3<T> d;
    load(dx + at, d.x), load(dy + at, d.y), load(dz + at, d.z);
    return d;
  }
  template <class T>
  KERNEL void write(int at, const Vector3<T>& d) const {
    store(d.x, dx + at), store(d.y, dy + at), store(d.z, dz + at);
  }
  template <class T>
  KERNEL void add(int at, const Vector3<T>& further) const {
    write(at, way<T>(at) + further);
  }
  KERNEL void add(int at, const Vec4<R>& further) const { add(at, further.xyz()); }
  template <class S>
  KERNEL void gather(const LocalIndex* index, Moving<S>& q) const {
    for (int i = 0; i < int(sizeof(S) / sizeof(R)); ++i) {
      const int at = index[i] / kIndexScale<R>;
      set_lane(q.x.x, i, x[at]), set_lane(q.x.y, i, y[at]), set_lane(q.x.z, i, z[at]), set_lane(q.w, i, w[at]);
      set_lane(q.d.x, i, dx[at]), set_lane(q.d.y, i, dy[at]), set_lane(q.d.z, i, dz[at]);
    }
  }
};

template <class R>
struct AosView {
  static constexpr bool side_by_side = false;
  Vec4<R>*row, *d;
  KERNEL static AosView over(R* memory, int slots) {
    Vec4<R>* const rows = reinterpret_cast<Vec4<R>*>(memory);
    return {rows, rows + slots};
  }
  KERNEL AosView ways() const { return {d, nullptr}; }

  template <class T>
  KERNEL void fill(int at, const Moving<T>& q) const {
    scatter_rows(row + at, Consecutive().index, q.x, q.w);
    write(at, q.d);
  }
  template <class T>
  KERNEL void read(int at, Moving<T>& q) const {
    gather_rows(row + at, Consecutive().index, q.x, q.w);
    q.d = way<T>(at);
  }
  template <class T>
  KERNEL Vector3<T> way(int at) const {
    Vector3<T> q;
    T none;
    gather_rows(d + at, Consecutive().index, q, none);
    return q;
  }
  template <class T>
  KERNEL void write(int at, const Vector3<T>& q) const {
    scatter_rows(d + at, Consecutive().index, q, T(R(0)));
  }
  template <class T>
  KERNEL void add(int at, const Vector3<T>& further) const {
    write(at, way<T>(at) + further);
  }
  /// further.w is 0.
  KERNEL void add(int at, const Vec4<R>& further) const { add_row(d[at], further, R(1)); }
  template <class S>
  KERNEL void gather(const LocalIndex* index, Moving<S>& q) const {
    S none;
    gather_rows(row, index, q.x, q.w);
    gather_rows(d, index, q.d, none);
  }
  template <class S>
  KERNEL void scatter(const LocalIndex* index, const Vector3<S>& way) const {
    scatter_rows(d, index, way, S(R(0)));
  }

 private:
  struct Consecutive {
    LocalIndex index[16];
    KERNEL Consecutive() {
      for (int i = 0; i < 16; ++i) index[i] = LocalIndex(i * kIndexScale<R>);
    }
  };
};

}  // namespace malha
