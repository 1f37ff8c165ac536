// SPDX-License-Identifier: Apache-2.0
// Tiles of sixteen numbers, four rows of four, in as many packs as an instruction set needs. Sums over tiles have the
// same bits on all of them.
#pragma once
#include "kernels/simd/rows.h"

namespace malha {

template <class R, class Isa>
struct Tile;

template <class R>
struct Tile<R, OneLane> {
  R part[16];

  KERNEL static Tile zero() { return broadcast(R(0)); }
  KERNEL static Tile broadcast(R number) {
    Tile t;
    for (int p = 0; p < 16; ++p) t.part[p] = number;
    return t;
  }
  /// Loads a tile. From: R, or integers, which are converted.
  template <class From>
  KERNEL static Tile load_from(const From* from) {
    Tile t;
    for (int p = 0; p < 16; ++p) t.part[p] = R(from[p]);
    return t;
  }
  KERNEL void store_to(R* to) const {
    for (int p = 0; p < 16; ++p) to[p] = part[p];
  }
  /// Adds the elementwise product of a and b.
  KERNEL void add_product(const Tile& a, const Tile& b) {
    for (int p = 0; p < 16; ++p) part[p] = part[p] + a.part[p] * b.part[p];
  }
  /// Splats row q: row r of the result is number r of it, four times.
  template <int q>
  KERNEL Tile splat_row() const {
    Tile t;
    for (int p = 0; p < 16; ++p) t.part[p] = part[4 * q + p / 4];
    return t;
  }
  /// A tile whose four rows are `row`.
  KERNEL static Tile repeat_row(const Vec4<R>& row) {
    Tile t;
    for (int p = 0; p < 16; p += 4)
      t.part[p] = row.x, t.part[p + 1] = row.y, t.part[p + 2] = row.z, t.part[p + 3] = row.w;
    return t;
  }
  /// Sums the rows as (row 0 + row 1) + (row 2 + row 3).
  KERNEL Vec4<R> sum_of_rows() const {
    const auto sum = [&](int k) KERNEL_LAMBDA { return (part[k] + part[4 + k]) + (part[8 + k] + part[12 + k]); };
    return {sum(0), sum(1), sum(2), sum(3)};
  }
  /// The sum of each of four tiles as a fixed tree: sum_of_rows(), and of that (x + y) + (z + w).
  KERNEL static Vec4<R> sums(const Tile& a, const Tile& b, const Tile& c, const Tile& d) {
    const auto sum = [](const Tile& t) KERNEL_LAMBDA {
      const Vec4<R> r = t.sum_of_rows();
      return (r.x + r.y) + (r.z + r.w);
    };
    return {sum(a), sum(b), sum(c), sum(d)};
  }
};

#if !defined(__CUDACC__)

/// A tile of packs.
template <class R, class Isa>
struct Tile {
  using S = Lane<R, Isa>;
  static constexpr int lanes = kLanes<R, Isa>, parts = 16 / lanes;
  S part[parts];

  KERNEL static Tile zero() {
    Tile t;
    for (int p = 0; p < parts; ++p) t.part[p] = S(0);
    return t;
  }
  KERNEL static Tile broadcast(R number) {
    Tile t;
    for (int p = 0; p < parts; ++p) t.part[p] = S(number);
    return t;
  }
  KERNEL static Tile load_from(const R* from) {
    Tile t;
    for (int p = 0; p < parts; ++p) load(from + p * lanes, t.part[p]);
    return t;
  }
  /// Loads integers and converts them.
  KERNEL static Tile load_from(const short* from) {
    Tile t;
    using Shorts = typename VectorOf<short, 2 * lanes>::Type;
    using Ints = typename VectorOf<int, 4 * lanes>::Type;
    for (int p = 0; p < parts; ++p) {
      Shorts some;
      __builtin_memcpy(&some, from + p * lanes, sizeof some);
      t.part[p].v = __builtin_convertvector(__builtin_convertvector(some, Ints), typename S::Vector);
    }
    return t;
  }
  KERNEL void store_to(R* to) const {
    for (int p = 0; p < parts; ++p) store(part[p], to + p * lanes);
  }
  /// Adds the elementwise product of a and b.
  KERNEL void add_product(const Tile& a, const Tile& b) {
    for (int p = 0; p < parts; ++p) part[p] = part[p] + a.part[p] * b.part[p];
  }
  /// Splats row q: row r of the result is number r of it, four times.
  template <int q>
  KERNEL Tile splat_row() const {
    Tile t;
    each_part([&]<int p>() KERNEL_LAMBDA {
      constexpr int first = 4 * q % lanes + p * lanes / 4;
      t.part[p].v = splat_from<first>(part[4 * q / lanes].v, detail::Count<lanes>{});
    });
    return t;
  }
  /// A tile whose four rows are `row`.
  KERNEL static Tile repeat_row(const Vec4<R>& row) {
    Tile t;
    constexpr LocalIndex here[16] = {};
    for (int p = 0; p < parts; ++p) t.part[p].v = detail::row<typename S::Vector>(const_cast<Vec4<R>*>(&row), here);
    return t;
  }
  /// Sums the rows as (row 0 + row 1) + (row 2 + row 3).
  KERNEL Vec4<R> sum_of_rows() const {
    Vec4<R> sum;
    const detail::Quartet<R> all = (row<0>() + row<1>()) + (row<2>() + row<3>());
    __builtin_memcpy(&sum, &all, sizeof all);
    return sum;
  }
  /// The sum of each of four tiles as a fixed tree: sum_of_rows(), and of that (x + y) + (z + w).
  KERNEL static Vec4<R> sums(const Tile& a, const Tile& b, const Tile& c, const Tile& d) {
    Vec4<R> r[4] = {a.sum_of_rows(), b.sum_of_rows(), c.sum_of_rows(), d.sum_of_rows()};
    detail::Quartet<R> q[4];
    __builtin_memcpy(q, r, sizeof q);
    detail::transpose<4>(q[0], q[1], q[2], q[3]);
    q[0] = (q[0] + q[1]) + (q[2] + q[3]);
    __builtin_memcpy(r, q, sizeof r[0]);
    return r[0];
  }

 private:
  template <class F, int... p>
  KERNEL static void call(const F& f, detail::Indices<p...>) {
    (f.template operator()<p>(), ...);
  }
  template <class F>
  KERNEL static void each_part(const F& f) {
    call(f, detail::Count<parts>{});
  }
  template <int r>
  KERNEL detail::Quartet<R> row() const {
    const auto all = part[4 * r / lanes].v;
    constexpr int first = 4 * r % lanes;
    return __builtin_shufflevector(all, all, first, first + 1, first + 2, first + 3);
  }
  template <int first, class V, int... i>
  KERNEL static V splat_from(V a, detail::Indices<i...>) {
    return __builtin_shufflevector(a, a, (first + i / 4)...);
  }
};

#endif

}  // namespace malha
