// SPDX-License-Identifier: Apache-2.0
// The four-quadrant arctangent for scalars and packs, in plain arithmetic: the same bits on every backend.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// atan2(y, x) in (-pi, pi], 0 for (0, 0). Cephes' rational approximation (Moshier 1989, atan.c), error below 3 ulp.
template <class S>
KERNEL S arctangent2(S y, S x) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1));
  const S ay = select(y < zero, -y, y), ax = select(x < zero, -x, x);
  // atan(ay / ax) with the quotient kept in [0, 0.66] or so: by 1 / t above tan(3 pi / 8), by (t - 1) / (t + 1)
  // between.
  const auto steep = ay > ax * S(R(2.41421356237309504880));
  const auto middle = ay > ax * S(R(0.66));
  const S top = select(steep, -ax, select(middle, ay - ax, ay));
  const S bottom = select(steep, ay, select(middle, ay + ax, ax));
  const S t = select(bottom > zero, top / select(bottom > zero, bottom, one), zero);
  const S z = t * t;
  const S p = (((S(R(-8.750608600031904122785e-1)) * z + S(R(-1.615753718733365076637e1))) * z +
                S(R(-7.500855792314704667340e1))) *
                   z +
               S(R(-1.228866684490136173410e2))) *
                  z +
              S(R(-6.485021904942025371773e1));
  const S q = ((((z + S(R(2.485846490142306297962e1))) * z + S(R(1.650270098316988542046e2))) * z +
                S(R(4.328810604912902668951e2))) *
                   z +
               S(R(4.853903996359136964868e2))) *
                  z +
              S(R(1.945506571482613964425e2));
  const S pi(R(3.14159265358979323846));
  const S base = select(steep, pi * S(R(0.5)), select(middle, pi * S(R(0.25)), zero));
  const S first = base + (t + t * (z * p / q));
  const S angle = select(x < zero, pi - first, first);
  return select(y < zero, -angle, angle);
}

}  // namespace malha
