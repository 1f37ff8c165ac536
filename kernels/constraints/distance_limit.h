// SPDX-License-Identifier: Apache-2.0
// distance_limit: C = (1 + tau) l - |p0 - p1| >= 0, Provot's elongation limit (Graphics Interface 1995) as an
// inequality: it acts only on edges that are stretched beyond the limit.
#pragma once
#include "kernels/constraints/distance.h"

namespace malha {

struct DistanceLimit {
  static constexpr const char* name = "distance_limit";
  static constexpr Element element = Element::Edges;
  static constexpr int particles = 2;
  static constexpr bool inequality = true;
  static constexpr bool has_strain = false;
  static constexpr Strength strength{true, nullptr, nullptr};
  static constexpr Filtered filtered = Filtered::After;
  static constexpr Degenerate degenerate = Degenerate::Skipped;
  static constexpr int rest_values = 1;
  static constexpr Parameter parameter{"limit", 0.1, 0, true};

  /// (1 + tau) l, m.
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[2], S limit, S (&rest)[1]) {
    Distance::rest(X, S(typename RealOf<S>::type(1)) + limit, rest);
  }

  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[2], const S* rest, const Mask& valid, Vector3<S> (&grad)[2],
                           S& scale) {
    const S excess = Distance::evaluate(p, rest, valid, grad, scale);
    grad[0] = -grad[0], grad[1] = -grad[1];
    return -excess;
  }
};

}  // namespace malha
