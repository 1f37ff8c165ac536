// SPDX-License-Identifier: Apache-2.0
// Packs: several constraints in the lanes of one register, with arithmetic, masks, loads and stores.
// On the CPU a pack is a compiler vector (no intrinsics, any instruction set, the same bits on all of them: every
// operation is elementwise IEEE). On a device every thread has one lane, a plain number (OneLane).
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

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
KERNEL void store(const double& from, float* to) { *to = float(from); }

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

  KERNEL friend Pack operator+(Pack a, Pack b) { return a.v + b.v; }
  KERNEL friend Pack operator-(Pack a, Pack b) { return a.v - b.v; }
  KERNEL friend Pack operator-(Pack a) { return -a.v; }
  KERNEL friend Pack operator*(Pack a, Pack b) { return a.v * b.v; }
  KERNEL friend Pack operator/(Pack a, Pack b) { return a.v / b.v; }
  KERNEL friend Mask operator<(Pack a, Pack b) { return a.v < b.v; }
  KERNEL friend Mask operator>(Pack a, Pack b) { return a.v > b.v; }
  KERNEL friend Mask operator<=(Pack a, Pack b) { return a.v <= b.v; }
  KERNEL friend Mask operator==(Pack a, Pack b) { return a.v == b.v; }
  KERNEL friend Pack select(Mask mask, Pack a, Pack b) { return mask ? a.v : b.v; }
  KERNEL friend Pack max(Pack a, Pack b) { return a.v > b.v ? a.v : b.v; }
  KERNEL friend Pack min(Pack a, Pack b) { return a.v < b.v ? a.v : b.v; }
  KERNEL friend Pack sqrt(Pack a) {
    Vector b = a.v;
    for (int lane = 0; lane < lanes; ++lane) b[lane] = sqrt(a.v[lane]);
    return b;
  }

  KERNEL friend R lane(const Pack& a, int i) { return a.v[i]; }
  KERNEL friend void set_lane(Pack& a, int i, R value) { a.v[i] = value; }
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
template <int bytes>
KERNEL void store(const Pack<double, bytes>& from, float* to) {
  using Floats = typename VectorOf<float, bytes / 2>::Anywhere;
  *reinterpret_cast<Floats*>(to) = __builtin_convertvector(from.v, typename VectorOf<float, bytes / 2>::Type);
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
#endif

}  // namespace malha
