// SPDX-License-Identifier: Apache-2.0
// Packs: several constraints in the lanes of one register, and the loads, stores, gathers and scatters of their
// particles.
// On the CPU a pack is a compiler vector (no intrinsics, any instruction set, the same bits on all of them: every
// operation is elementwise IEEE). On a device every thread has one lane, a plain number (OneLane).
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

/// Index of a particle within a patch, scaled so that 8 * index is its offset in bytes among rows (Vec4) of R, which is
/// an addressing mode. Wider integers (Index below) number the particles of any model in the same way.
using LocalIndex = unsigned short;
template <class R>
inline constexpr int kIndexScale = int(sizeof(Vec4<R>)) / 8;

/// Loads and stores one number, or (below) a pack of them, at any address of an array.
template <class R>
KERNEL void load(const R* from, R& to) {
  to = *from;
}
KERNEL void load(const float* from, double& to) { to = *from; }
template <class R>
KERNEL void store(const R& from, R* to) {
  *to = from;
}

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

/// Lanes of a pack of R: as many as a register has, but at least four, because particles are gathered and scattered in
/// blocks of four.
template <class R, class Isa = NativeIsa>
inline constexpr int kLanes = Isa::register_bytes < 4 * int(sizeof(R)) ? 4 : Isa::register_bytes / int(sizeof(R));
template <class R>
inline constexpr int kLanes<R, OneLane> = 1;

template <class R, int lanes>
struct LaneOf;
template <class R>
struct LaneOf<R, 1> {
  using type = R;
};
template <class R, class Isa = NativeIsa>
using Lane = typename LaneOf<R, kLanes<R, Isa>>::type;

/// The lane access of packs (below), for a single number.
template <class R>
KERNEL R lane(const R& a, int) {
  return a;
}
template <class R>
KERNEL void set_lane(R& a, int, R value) {
  a = value;
}
template <class S>
requires(sizeof(S) == sizeof(typename RealOf<S>::type)) KERNEL bool mask_from_bits(unsigned bits) { return bits & 1; }

#if !defined(__CUDACC__)

/// The compiler's vector type. It has a struct of its own because within Pack g++ 12 would take it for R.
template <class R, int bytes>
struct VectorOf {
  typedef R Type __attribute__((vector_size(bytes)));
  typedef R Anywhere __attribute__((vector_size(bytes), may_alias, aligned(sizeof(R))));
};

template <class R, int bytes>
struct Pack {
  using Vector = typename VectorOf<R, bytes>::Type;
  using Mask = decltype(Vector{} < Vector{});
  static constexpr int lanes = bytes / int(sizeof(R));
  Vector v;
  Pack() = default;
  KERNEL Pack(Vector a) : v(a) {}
  /// Broadcasts a; -0 becomes 0. (Without the sum g++ 12 fills the lanes one by one in functions that are compiled for
  /// another instruction set than the build's.)
  KERNEL Pack(R a) : v(Vector{} + a) {}
};

template <class R, int lanes>
struct LaneOf {
  using type = Pack<R, lanes* int(sizeof(R))>;
};
template <class R, int bytes>
struct RealOf<Pack<R, bytes>> {
  using type = R;
};

template <class R, int bytes>
KERNEL Pack<R, bytes> operator+(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v + b.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> operator-(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v - b.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> operator-(Pack<R, bytes> a) {
  return -a.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> operator*(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v * b.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> operator/(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v / b.v;
}
template <class R, int bytes>
KERNEL typename Pack<R, bytes>::Mask operator<(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v < b.v;
}
template <class R, int bytes>
KERNEL typename Pack<R, bytes>::Mask operator>(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v > b.v;
}
template <class R, int bytes>
KERNEL typename Pack<R, bytes>::Mask operator<=(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v <= b.v;
}
template <class R, int bytes>
KERNEL typename Pack<R, bytes>::Mask operator==(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v == b.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> select(typename Pack<R, bytes>::Mask mask, Pack<R, bytes> a, Pack<R, bytes> b) {
  return mask ? a.v : b.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> max(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v > b.v ? a.v : b.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> min(Pack<R, bytes> a, Pack<R, bytes> b) {
  return a.v < b.v ? a.v : b.v;
}
template <class R, int bytes>
KERNEL Pack<R, bytes> sqrt(Pack<R, bytes> a) {
  typename Pack<R, bytes>::Vector b = a.v;
  for (int lane = 0; lane < Pack<R, bytes>::lanes; ++lane) b[lane] = sqrt(a.v[lane]);
  return b;
}

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
struct Indices {};
template <class A, class B>
struct Append;
template <int... I, int... J>
struct Append<Indices<I...>, Indices<J...>> {
  using type = Indices<I..., J...>;
};
template <int n>
struct Count {
  using type = typename Append<typename Count<n - 1>::type, Indices<n - 1>>::type;
};
template <>
struct Count<0> {
  using type = Indices<>;
};

template <class V, int... I>
KERNEL auto join(V a, V b, Indices<I...>) {
  return __builtin_shufflevector(a, b, I...);
}

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
  constexpr typename Count<n>::type all{};
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
  } else if constexpr (n == 2) {
    return join(quartet(rows, index[0]), quartet(rows, index[4]), typename Count<8>::type{});
  } else {
    constexpr Count<8>::type eight{};
    return join(join(quartet(rows, index[0]), quartet(rows, index[4]), eight),
                join(quartet(rows, index[8]), quartet(rows, index[12]), eight), typename Count<16>::type{});
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

template <class R, int bytes>
KERNEL void load(const R* from, Pack<R, bytes>& to) {
  to.v = *reinterpret_cast<const typename VectorOf<R, bytes>::Anywhere*>(from);
}
template <int bytes>
KERNEL void load(const float* from, Pack<double, bytes>& to) {
  using Floats = typename VectorOf<float, bytes / 2>::Anywhere;
  to.v = __builtin_convertvector(*reinterpret_cast<const Floats*>(from), typename Pack<double, bytes>::Vector);
}
template <class R, int bytes>
KERNEL void store(const Pack<R, bytes>& from, R* to) {
  *reinterpret_cast<typename VectorOf<R, bytes>::Anywhere*>(to) = from.v;
}
/// The mask of the lanes whose bits are set, the lowest for the first lane.
template <class S>
requires requires { typename S::Mask; }
KERNEL typename S::Mask mask_from_bits(unsigned bits) {
  typename S::Mask bit;
  for (int i = 0; i < S::lanes; ++i) bit[i] = 1 << i;
  return (bit & static_cast<int>(bits)) != 0;
}
/// One bit for each lane, set where the mask is, the lowest for the first lane.
template <class Mask>
requires requires(Mask mask) { mask[0]; }
KERNEL unsigned movemask(const Mask& mask) {
  constexpr int lanes = sizeof(Mask) / sizeof(mask[0]);
#if defined(__AVX512DQ__)  // one instruction, in builds for this machine
  typedef int Ints __attribute__((vector_size(64)));
  if constexpr (sizeof(Mask) == 64 && lanes == 16) return (unsigned short)__builtin_ia32_cvtd2mask512((Ints)mask);
#elif defined(__AVX2__)
  typedef float Floats __attribute__((vector_size(32)));
  if constexpr (sizeof(Mask) == 32 && lanes == 8) return unsigned(__builtin_ia32_movmskps256((Floats)mask));
#endif
  typedef signed char Bytes __attribute__((vector_size(lanes)));
  const Bytes bytes = __builtin_convertvector(mask, Bytes);
  unsigned bits = 0;
  for (int k = 0; k < lanes; k += 8) {
    unsigned long long eight = 0;  // the product gathers its lowest bits in the highest byte
    __builtin_memcpy(&eight, reinterpret_cast<const char*>(&bytes) + k, lanes < 8 ? lanes : 8);
    bits |= unsigned((eight & 0x0101010101010101ull) * 0x0102040810204080ull >> 56) << k;
  }
  return bits;
}
template <class R, int bytes>
KERNEL R lane(const Pack<R, bytes>& a, int i) {
  return a.v[i];
}
template <class R, int bytes>
KERNEL void set_lane(Pack<R, bytes>& a, int i, R value) {
  a.v[i] = value;
}

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

/// Loads and stores the points i, i + 1, ... of a pack, or the point i of a scalar.
template <class T, class R>
KERNEL Vector3<T> load_points(const Points<R>& points, int i) {
  Vector3<T> a;
  load(points.x + i, a.x), load(points.y + i, a.y), load(points.z + i, a.z);
  return a;
}
/// Positions at the start of the substep, relative to an origin near them.
template <class T, class R>
KERNEL Vector3<T> load_start(const Displaced<R>& points, int i, const Vector3<R>& origin, T) {
  const Vector3<T> x = load_points<T>(points.x, i) - Vector3<T>{T(origin.x), T(origin.y), T(origin.z)};
  if constexpr (kCompensated<R>)
    return x + load_points<T>(points.low, i);
  else
    return x;
}
/// Current positions.
template <class T, class R>
KERNEL Vector3<T> load_points(const Displaced<R>& points, int i) {
  Vector3<T> offset = load_points<T>(points.d, i);
  if constexpr (kCompensated<R>) offset = offset + load_points<T>(points.low, i);
  return load_points<T>(points.x, i) + offset;
}
template <class T, class R>
KERNEL void store_points(const Points<R>& points, int i, const Vector3<T>& a) {
  store(a.x, points.x + i), store(a.y, points.y + i), store(a.z, points.z + i);
}

}  // namespace malha
