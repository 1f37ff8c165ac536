// SPDX-License-Identifier: Apache-2.0
// Rows: the four numbers of a particle side by side, and their gathers and scatters. A pack of particles is gathered
// by one load for each particle and a transposition in registers.
#pragma once
#include <utility>

#include "kernels/simd/pack.h"

namespace malha {

/// Index of a particle within a patch, scaled so that 8 * index is its offset in bytes among rows (Vec4) of R, which is
/// an addressing mode. Wider integers (Index below) number the particles of any model in the same way.
using LocalIndex = unsigned short;
template <class R>
inline constexpr int kIndexScale = int(sizeof(Vec4<R>)) / 8;

/// Gathers one particle, or (below) a pack of them, from rows, and scatters them to rows.
template <class R, class Index>
KERNEL Vec4<R>& row_at(Vec4<R>* rows, Index index) {
  return rows[index / kIndexScale<R>];
}
template <class R, class Index>
KERNEL void gather_rows(Vec4<R>* rows, const Index* index, Vector3<R>& position, R& w) {
  const Vec4<R> q = row_at(rows, *index);
  position = q.xyz();
  w = q.w;
}
template <class R, class Index>
KERNEL void scatter_rows(Vec4<R>* rows, const Index* index, const Vector3<R>& position, R w) {
  row_at(rows, *index) = {position.x, position.y, position.z, w};
}

#if !defined(__CUDACC__)

namespace detail {

/// The four numbers of one particle's row as a vector.
template <class R>
struct Four {
  typedef R Vector __attribute__((vector_size(4 * sizeof(R)), may_alias));
};
template <class R>
using Quartet = typename Four<R>::Vector;

#if !defined(__clang__)
__extension__ typedef __int128 Bits16 __attribute__((may_alias));
__extension__ typedef __int128 Bits16x2 __attribute__((vector_size(32)));
__extension__ typedef __int128 Bits16x4 __attribute__((vector_size(64)));
#endif

template <int... I>
using Indices = std::integer_sequence<int, I...>;
/// The indices 0 .. n - 1.
template <int n>
using Count = std::make_integer_sequence<int, n>;

/// The four lanes from 4 * block on. (g++ stores them straight to memory from this, but not from a shuffle.)
template <class R, int block, class V>
KERNEL Quartet<R> quarter(V a) {
  Quartet<R> four;
  __builtin_memcpy(&four, reinterpret_cast<const char*>(&a) + block * sizeof four, sizeof four);
  return four;
}

/// Within each block of four lanes, picks lanes a, b of u and c - 4, d - 4 of v, in the order of the arguments.
template <int n, int a, int b, int c, int d, class V, int... I>
KERNEL V blend(V u, V v, Indices<I...>) {
  constexpr int pick[4] = {a, b, c, d};
  return __builtin_shufflevector(u, v, (I / 4 * 4 + pick[I % 4] % 4 + pick[I % 4] / 4 * n)...);
}

/// Transposes every 4 x 4 block that lies across the four rows. Its own inverse.
template <int n, class V>
KERNEL void transpose(V& r0, V& r1, V& r2, V& r3) {
  constexpr Count<n> all{};
  const V a = blend<n, 0, 4, 1, 5>(r0, r1, all), b = blend<n, 0, 4, 1, 5>(r2, r3, all);
  const V c = blend<n, 2, 6, 3, 7>(r0, r1, all), d = blend<n, 2, 6, 3, 7>(r2, r3, all);
  r0 = blend<n, 0, 1, 4, 5>(a, b, all), r1 = blend<n, 2, 3, 6, 7>(a, b, all);
  r2 = blend<n, 0, 1, 4, 5>(c, d, all), r3 = blend<n, 2, 3, 6, 7>(c, d, all);
}

template <class R, class Index>
KERNEL char* address(Vec4<R>* rows, Index index) {
  return reinterpret_cast<char*>(rows) + size_t(8) * index;
}
/// (quartet() and bits() are two functions because a template's argument loses may_alias.)
template <class R, class Index>
KERNEL Quartet<R>& quartet(Vec4<R>* rows, Index index) {
  return *reinterpret_cast<Quartet<R>*>(address(rows, index));
}
#if !defined(__clang__)
template <class R, class Index>
KERNEL Bits16& bits(Vec4<R>* rows, Index index) {
  return *reinterpret_cast<Bits16*>(address(rows, index));
}
#endif

/// The rows of particles index[0], index[4], ... next to each other: called with index + k it gives row k of a gather,
/// and after the transposition lane j belongs to particle index[j].
template <class V, class R, class Index>
KERNEL V row(Vec4<R>* rows, const Index* index) {
  constexpr int n = int(sizeof(V) / sizeof(Vec4<R>));
  if constexpr (n == 1) {
    return quartet(rows, index[0]);
#if defined(__clang__)
  } else {
    V all;
    for (int k = 0; k < n; ++k)
      __builtin_memcpy(reinterpret_cast<char*>(&all) + k * sizeof(Vec4<R>), address(rows, index[4 * k]),
                       sizeof(Vec4<R>));
    return all;
#else
  } else if constexpr (sizeof(Vec4<R>) == 16) {  // as 16-byte elements: g++ then inserts straight from memory
    if constexpr (n == 2) return (V)(Bits16x2{bits(rows, index[0]), bits(rows, index[4])});
    if constexpr (n == 4)
      return (V)(Bits16x4{bits(rows, index[0]), bits(rows, index[4]), bits(rows, index[8]), bits(rows, index[12])});
  } else {
    Bits16 *first = &bits(rows, index[0]), *second = &bits(rows, index[4]);
    return (V)(Bits16x4{first[0], first[1], second[0], second[1]});
#endif
  }
}

template <int block, class R, class Index, class V>
KERNEL void scatter_block(Vec4<R>* rows, const Index* index, V r0, V r1, V r2, V r3) {
  quartet(rows, index[4 * block]) = quarter<R, block>(r0);
  quartet(rows, index[4 * block + 1]) = quarter<R, block>(r1);
  quartet(rows, index[4 * block + 2]) = quarter<R, block>(r2);
  quartet(rows, index[4 * block + 3]) = quarter<R, block>(r3);
}

}  // namespace detail

/// Gathers the particles index[0] .. index[lanes - 1] by one aligned load each and a transposition in registers.
template <class R, int bytes, class Index>
KERNEL void gather_rows(Vec4<R>* rows, const Index* index, Vector3<Pack<R, bytes>>& position, Pack<R, bytes>& w) {
  using V = typename Pack<R, bytes>::Vector;
  position.x.v = detail::row<V>(rows, index);
  position.y.v = detail::row<V>(rows, index + 1);
  position.z.v = detail::row<V>(rows, index + 2);
  w.v = detail::row<V>(rows, index + 3);
  detail::transpose<Pack<R, bytes>::lanes>(position.x.v, position.y.v, position.z.v, w.v);
}

/// Scatters all lanes: the particles must be distinct.
template <class R, int bytes, class Index>
KERNEL void scatter_rows(Vec4<R>* rows, const Index* index, Vector3<Pack<R, bytes>> position, Pack<R, bytes> w) {
  constexpr int lanes = Pack<R, bytes>::lanes;
  detail::transpose<lanes>(position.x.v, position.y.v, position.z.v, w.v);
  detail::scatter_block<0>(rows, index, position.x.v, position.y.v, position.z.v, w.v);
  if constexpr (lanes > 4) detail::scatter_block<1>(rows, index, position.x.v, position.y.v, position.z.v, w.v);
  if constexpr (lanes > 8) {
    detail::scatter_block<2>(rows, index, position.x.v, position.y.v, position.z.v, w.v);
    detail::scatter_block<3>(rows, index, position.x.v, position.y.v, position.z.v, w.v);
  }
}

#endif

/// sum += weight * row, all four numbers at once.
template <class R>
KERNEL void add_row(Vec4<R>& sum, const Vec4<R>& row, R weight) {
#if defined(__CUDACC__)
  sum = {sum.x + row.x * weight, sum.y + row.y * weight, sum.z + row.z * weight, sum.w + row.w * weight};
#else
  using Quartet = detail::Quartet<R>;
  Quartet& to = reinterpret_cast<Quartet&>(sum);
  to = to + reinterpret_cast<const Quartet&>(row) * weight;
#endif
}

}  // namespace malha
