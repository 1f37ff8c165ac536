// SPDX-License-Identifier: Apache-2.0
// The natural logarithm for scalars and packs, in plain arithmetic: the same bits on every backend.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

namespace detail {

/// Splits a positive normal number a = m 2^e by its IEEE 754 bits: returns m in [1, 2), and sets e.
KERNEL float split(float a, float& e) {
  int bits;
  __builtin_memcpy(&bits, &a, sizeof bits);
  e = float((bits >> 23) - 127);
  bits = (bits & 0x007fffff) | 0x3f800000;
  __builtin_memcpy(&a, &bits, sizeof bits);
  return a;
}
KERNEL double split(double a, double& e) {
  long long bits;
  __builtin_memcpy(&bits, &a, sizeof bits);
  e = double((bits >> 52) - 1023);
  bits = (bits & 0x000fffffffffffffll) | 0x3ff0000000000000ll;
  __builtin_memcpy(&a, &bits, sizeof bits);
  return a;
}
#if !defined(__CUDACC__)
template <class R, int bytes>
KERNEL Pack<R, bytes> split(Pack<R, bytes> a, Pack<R, bytes>& e) {
  Pack<R, bytes> m;
  for (int i = 0; i < Pack<R, bytes>::lanes; ++i) {
    R own = R(0);
    m.v[i] = split(R(a.v[i]), own);
    e.v[i] = own;
  }
  return m;
}
#endif

}  // namespace detail

/// log(a) of a positive a; denormal numbers count as the smallest normal one. Cephes' rational approximation (Moshier
/// 1989, log.c), error below 2 ulp.
template <class S>
KERNEL S logarithm(S a) {
  using R = typename RealOf<S>::type;
  const S one(R(1)), half(R(0.5));
  S e;
  S m = detail::split(max(a, S(sizeof(R) == 4 ? R(1.17549435e-38) : R(2.2250738585072014e-308))), e);
  const auto upper = m > S(R(1.41421356237309504880));
  m = select(upper, m * half, m), e = select(upper, e + one, e);
  const S x = m - one, z = x * x;
  const S p =
      ((((S(R(1.01875663804580931796e-4)) * x + S(R(4.97494994976747001425e-1))) * x + S(R(4.70579119878881725854))) *
            x +
        S(R(1.44989225341610930846e1))) *
           x +
       S(R(1.79368678507819816313e1))) *
          x +
      S(R(7.70838733755885391666));
  const S q = ((((x + S(R(1.12873587189167450590e1))) * x + S(R(4.52279145837532221105e1))) * x +
                S(R(8.29875266912776603211e1))) *
                   x +
               S(R(7.11544750618563894466e1))) *
                  x +
              S(R(2.31251620126765340583e1));
  const S y = x * (z * p / q) - e * S(R(2.121944400546905827679e-4)) - half * z;
  return x + y + e * S(R(0.693359375));
}

}  // namespace malha
