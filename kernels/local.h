// The fast memory of a patch, laid out in one of two ways: columns (an array a coordinate) where packs read particles
// that lie side by side, rows (a Vec4 a particle) where they gather them from anywhere.
#pragma once
#include "kernels/pack.h"

namespace malha {

/// What both offer. T is R for one particle or Lane<R> for the pack of particles at, at + 1, ...
/// fill: position and w; read: both. Packs of any particles are gathered from both; they are scattered to rows only:
/// the few in columns are filled one by one.
template <class R>
struct Columns {
  static constexpr bool side_by_side = true;
  R *x, *y, *z, *w;
  /// The first `slots` numbers of `memory` are x, and so on.
  KERNEL static Columns over(R* memory, int slots) {
    return {memory, memory + slots, memory + 2 * slots, memory + 3 * slots};
  }
  KERNEL Columns from(int at) const { return {x + at, y + at, z + at, w + at}; }

  template <class T>
  KERNEL void fill(int at, const Vector3<T>& q, const T& wq) const {
    write(at, q, wq);
    store(wq, w + at);
  }
  template <class T>
  KERNEL void read(int at, Vector3<T>& q, T& wq) const {
    load(x + at, q.x), load(y + at, q.y), load(z + at, q.z), load(w + at, wq);
  }
  /// The position, where w is known to be there.
  template <class T>
  KERNEL void write(int at, const Vector3<T>& q, const T&) const {
    store(q.x, x + at), store(q.y, y + at), store(q.z, z + at);
  }
  /// To the positions; w stays.
  template <class T>
  KERNEL void add(int at, const Vector3<T>& way) const {
    Vector3<T> q;
    load(x + at, q.x), load(y + at, q.y), load(z + at, q.z);
    write(at, q + way, q.x);
  }
  KERNEL void add(int at, const Vec4<R>& way) const { add(at, way.xyz()); }
  template <class S>
  KERNEL void gather(const LocalIndex* index, Vector3<S>& q, S& wq) const {
    for (int i = 0; i < int(sizeof(S) / sizeof(R)); ++i) {
      const int at = index[i] / kIndexScale<R>;
      set_lane(q.x, i, x[at]), set_lane(q.y, i, y[at]), set_lane(q.z, i, z[at]), set_lane(wq, i, w[at]);
    }
  }
};

template <class R>
struct Rows {
  static constexpr bool side_by_side = false;
  Vec4<R>* row;
  KERNEL static Rows over(R* memory, int /*slots*/) { return {reinterpret_cast<Vec4<R>*>(memory)}; }

  template <class T>
  KERNEL void fill(int at, const Vector3<T>& q, const T& w) const {
    scatter_rows(row + at, Consecutive().index, q, w);
  }
  template <class T>
  KERNEL void read(int at, Vector3<T>& q, T& w) const {
    gather_rows(row + at, Consecutive().index, q, w);
  }
  template <class T>
  KERNEL void add(int at, const Vector3<T>& way) const {
    Vector3<T> q;
    T w;
    read(at, q, w);
    fill(at, q + way, w);
  }
  /// way.w is 0.
  KERNEL void add(int at, const Vec4<R>& way) const { add_row(row[at], way, R(1)); }
  template <class S>
  KERNEL void gather(const LocalIndex* index, Vector3<S>& q, S& w) const {
    gather_rows(row, index, q, w);
  }
  template <class S>
  KERNEL void scatter(const LocalIndex* index, const Vector3<S>& q, const S& w) const {
    scatter_rows(row, index, q, w);
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
