// Packs: several constraints side by side in one register, and how their particles come in and go out.
// On the CPU a pack is a compiler vector (no intrinsics, any instruction set, the same bits on all of them: every
// operation is elementwise IEEE). Under CUDA a lane is a plain scalar, and the pack of a thread is one wide.
#pragma once
#include "kernels/vec.h"

namespace malha {

#if defined(__CUDACC__)

template <class R>
inline constexpr int kLanes = 1;
template <class R>
using Lane = R;

template <class R>
KERNEL void load(const R* from, R& to) {
  to = *from;
}
template <class R>
KERNEL void store(const R& from, R* to) {
  *to = from;
}
template <class R>
KERNEL void gather(const Vec4<R>* particles, const int* index, Vector3<R>& position, R& w) {
  const Vec4<R> q = particles[*index];
  position = q.xyz();
  w = q.w;
}
template <class R>
KERNEL void scatter(Vec4<R>* particles, const int* index, const Vector3<R>& position, R w) {
  particles[*index] = {position.x, position.y, position.z, w};
}
template <class R>
KERNEL void scatter_movable(Vec4<R>* particles, const int* index, int /*lanes*/, const Vector3<R>& position, R w) {
  if (w > R(0)) scatter(particles, index, position, w);
}

#else

#if defined(__AVX512F__)
inline constexpr int kPackBytes = 64;
#else
inline constexpr int kPackBytes = 32;
#endif

/// Lanes of a pack of R.
template <class R>
inline constexpr int kLanes = kPackBytes / int(sizeof(R));

/// The compiler's vector types: a whole pack, and one particle.
template <class R>
struct Vectors;
template <>
struct Vectors<float> {
  typedef float Wide __attribute__((vector_size(kPackBytes)));
  typedef float Quartet __attribute__((vector_size(16), may_alias));
};
template <>
struct Vectors<double> {
  typedef double Wide __attribute__((vector_size(kPackBytes)));
  typedef double Quartet __attribute__((vector_size(32), may_alias));
};

template <class R>
struct Pack {
  using Vector = typename Vectors<R>::Wide;
  using Mask = decltype(Vector{} < Vector{});
  Vector v;
  Pack() = default;
  KERNEL Pack(Vector a) : v(a) {}
  KERNEL Pack(R a) : v(a - Vector{}) {}
};

template <class R>
using Lane = Pack<R>;

template <class R>
KERNEL Pack<R> operator+(Pack<R> a, Pack<R> b) {
  return a.v + b.v;
}
template <class R>
KERNEL Pack<R> operator-(Pack<R> a, Pack<R> b) {
  return a.v - b.v;
}
template <class R>
KERNEL Pack<R> operator-(Pack<R> a) {
  return -a.v;
}
template <class R>
KERNEL Pack<R> operator*(Pack<R> a, Pack<R> b) {
  return a.v * b.v;
}
template <class R>
KERNEL Pack<R> operator/(Pack<R> a, Pack<R> b) {
  return a.v / b.v;
}
template <class R>
KERNEL typename Pack<R>::Mask operator<(Pack<R> a, Pack<R> b) {
  return a.v < b.v;
}
template <class R>
KERNEL typename Pack<R>::Mask operator>(Pack<R> a, Pack<R> b) {
  return a.v > b.v;
}
template <class R>
KERNEL Pack<R> select(typename Pack<R>::Mask mask, Pack<R> a, Pack<R> b) {
  return mask ? a.v : b.v;
}
template <class R>
KERNEL Pack<R> larger(Pack<R> a, Pack<R> b) {
  return a.v > b.v ? a.v : b.v;
}
template <class R>
KERNEL Pack<R> root(Pack<R> a) {
  typename Pack<R>::Vector b;
  for (int lane = 0; lane < kLanes<R>; ++lane) b[lane] = root(a.v[lane]);
  return b;
}

namespace detail {

template <class R>
using Quartet = typename Vectors<R>::Quartet;

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

/// Four lanes starting at 4 * block.
template <class R, int block, class V>
KERNEL Quartet<R> quarter(V a) {
  return __builtin_shufflevector(a, a, 4 * block, 4 * block + 1, 4 * block + 2, 4 * block + 3);
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

template <class R>
KERNEL Quartet<R> quartet(const Vec4<R>* particles, int i) {
  return *reinterpret_cast<const Quartet<R>*>(particles + i);
}

/// Row k: particle index[k], then index[k + 4], ...: after the transposition lane j belongs to index[j].
template <class R>
KERNEL typename Pack<R>::Vector row(const Vec4<R>* particles, const int* index) {
  constexpr Count<8>::type eight{};
  if constexpr (kLanes<R> == 4) {
    return quartet(particles, index[0]);
  } else if constexpr (kLanes<R> == 8) {
    return join(quartet(particles, index[0]), quartet(particles, index[4]), eight);
  } else {
    static_assert(kLanes<R> == 16);
    return join(join(quartet(particles, index[0]), quartet(particles, index[4]), eight),
                join(quartet(particles, index[8]), quartet(particles, index[12]), eight), typename Count<16>::type{});
  }
}

template <class R, int block>
KERNEL void put(Vec4<R>* particles, const int* index, typename Pack<R>::Vector r0, typename Pack<R>::Vector r1,
                typename Pack<R>::Vector r2, typename Pack<R>::Vector r3) {
  *reinterpret_cast<Quartet<R>*>(particles + index[4 * block]) = quarter<R, block>(r0);
  *reinterpret_cast<Quartet<R>*>(particles + index[4 * block + 1]) = quarter<R, block>(r1);
  *reinterpret_cast<Quartet<R>*>(particles + index[4 * block + 2]) = quarter<R, block>(r2);
  *reinterpret_cast<Quartet<R>*>(particles + index[4 * block + 3]) = quarter<R, block>(r3);
}

}  // namespace detail

template <class R>
KERNEL void load(const R* from, Pack<R>& to) {
  to.v = *reinterpret_cast<const typename Pack<R>::Vector*>(from);
}
template <class R>
KERNEL void store(const Pack<R>& from, R* to) {
  *reinterpret_cast<typename Pack<R>::Vector*>(to) = from.v;
}

/// Reads the particles index[0] .. index[lanes - 1]: one aligned load each, then transposes in registers.
template <class R>
KERNEL void gather(const Vec4<R>* particles, const int* index, Vector3<Pack<R>>& position, Pack<R>& w) {
  position.x.v = detail::row(particles, index);
  position.y.v = detail::row(particles, index + 1);
  position.z.v = detail::row(particles, index + 2);
  w.v = detail::row(particles, index + 3);
  detail::transpose<kLanes<R>>(position.x.v, position.y.v, position.z.v, w.v);
}

/// Writes them back, all lanes: the particles must be distinct.
template <class R>
KERNEL void scatter(Vec4<R>* particles, const int* index, Vector3<Pack<R>> position, Pack<R> w) {
  detail::transpose<kLanes<R>>(position.x.v, position.y.v, position.z.v, w.v);
  detail::put<R, 0>(particles, index, position.x.v, position.y.v, position.z.v, w.v);
  if constexpr (kLanes < R >> 4) detail::put<R, 1>(particles, index, position.x.v, position.y.v, position.z.v, w.v);
  if constexpr (kLanes < R >> 8) {
    detail::put<R, 2>(particles, index, position.x.v, position.y.v, position.z.v, w.v);
    detail::put<R, 3>(particles, index, position.x.v, position.y.v, position.z.v, w.v);
  }
}

/// Writes back the first `lanes` of them, and of those only the movable (w > 0): pinned particles may be shared.
template <class R>
KERNEL void scatter_movable(Vec4<R>* particles, const int* index, int lanes, const Vector3<Pack<R>>& position,
                            Pack<R> w) {
  for (int lane = 0; lane < lanes; ++lane)
    if (w.v[lane] > R(0))
      particles[index[lane]] = {position.x.v[lane], position.y.v[lane], position.z.v[lane], w.v[lane]};
}

#endif

/// The number type under a lane: R for R and for Pack<R>.
template <class S>
struct RealOf {
  using type = S;
};
#if !defined(__CUDACC__)
template <class R>
struct RealOf<Pack<R>> {
  using type = R;
};
#endif

}  // namespace malha
