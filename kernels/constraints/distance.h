// distance: C = |p0 - p1| - l.  Müller et al. 2006, section 4.1.
#pragma once
#include "kernels/constraint.h"

namespace malha {

struct Distance {
  static constexpr const char* name = "distance";
  static constexpr Element element = Element::Edges;
  static constexpr int particles = 2;
  static constexpr bool inequality = false;
  static constexpr bool has_strain = true;  // C / l
  static constexpr Parameter parameter{"rest_scale", 1, 0, false};

  /// l, m: the distance at rest times rest_scale.
  template <class S>
  KERNEL static S rest(const Vector3<S> (&X)[2], S rest_scale) {
    const Vector3<S> d = X[0] - X[1];
    return root(dot(d, d)) * rest_scale;
  }

  template <class S>
  KERNEL static S evaluate(const Vector3<S> (&p)[2], S l, Vector3<S> (&grad)[2]) {
    using R = typename RealOf<S>::type;
    const Vector3<S> d = p[0] - p[1];
    const S squared = dot(d, d);
    const auto apart = squared > S(tiny<R>());  // coincident points have no direction: a zero gradient skips them
    const S length = root(squared);
    grad[0] = d * select(apart, S(R(1)) / select(apart, length, S(R(1))), S(R(0)));
    grad[1] = -grad[0];
    return length - l;
  }
};

}  // namespace malha
