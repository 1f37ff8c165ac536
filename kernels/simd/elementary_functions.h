// SPDX-License-Identifier: Apache-2.0
// Arctangent and logarithm for scalars and packs, in plain arithmetic: the same bits on every backend.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// atan2(y, x) in (-pi, pi], 0 for (0, 0). Cephes' rational approximation (Moshier 1989, atan.c), error below 3 ulp.
template <class S>
KERNEL S arctangent2(S y, S x) {
  const S zero(0), one(1);
  const S ay = select(y < zero, -y, y), ax = select(x < zero, -x, x);
  // atan(ay / ax) with the quotient kept in [0, 0.66] or so: by 1 / t above tan(3 pi / 8), by (t - 1) / (t + 1)
  // between.
  const auto steep = ay > ax * S(2.41421356237309504880);
  const auto middle = ay > ax * S(0.66);
  const S top = select(steep, -ax, select(middle, ay - ax, ay));
  const S bottom = select(steep, ay, select(middle, ay + ax, ax));
  const S t = select(bottom > zero, top / select(bottom > zero, bottom, one), zero);
  const S z = t * t;
  const S p =
      (((S(-8.750608600031904122785e-1) * z + S(-1.615753718733365076637e1)) * z + S(-7.500855792314704667340e1)) * z +
       S(-1.228866684490136173410e2)) *
          z +
      S(-6.485021904942025371773e1);
  const S q =
      ((((z + S(2.485846490142306297962e1)) * z + S(1.650270098316988542046e2)) * z + S(4.328810604912902668951e2)) *
           z +
       S(4.853903996359136964868e2)) *
          z +
      S(1.945506571482613964425e2);
  const S pi(3.14159265358979323846);
  const S base = select(steep, pi * S(0.5), select(middle, pi * S(0.25), zero));
  const S first = base + (t + t * (z * p / q));
  const S angle = select(x < zero, pi - first, first);
  return select(y < zero, -angle, angle);
}

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
  const S one(1), half(0.5);
  S e;
  S m = detail::split(max(a, S(sizeof(R) == 4 ? R(1.17549435e-38) : R(2.2250738585072014e-308))), e);
  const auto upper = m > S(1.41421356237309504880);
  m = select(upper, m * half, m), e = select(upper, e + one, e);
  const S x = m - one, z = x * x;
  const S p =
      ((((S(1.01875663804580931796e-4) * x + S(4.97494994976747001425e-1)) * x + S(4.70579119878881725854)) * x +
        S(1.44989225341610930846e1)) *
           x +
       S(1.79368678507819816313e1)) *
          x +
      S(7.70838733755885391666);
  const S q =
      ((((x + S(1.12873587189167450590e1)) * x + S(4.52279145837532221105e1)) * x + S(8.29875266912776603211e1)) * x +
       S(7.11544750618563894466e1)) *
          x +
      S(2.31251620126765340583e1);
  const S y = x * (z * p / q) - e * S(2.121944400546905827679e-4) - half * z;
  return x + y + e * S(0.693359375);
}

}  // namespace malha
