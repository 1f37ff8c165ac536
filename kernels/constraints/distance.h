// SPDX-License-Identifier: Apache-2.0
// distance: C = |p0 - p1| - l.  Müller et al. 2006, section 4.1.
#pragma once
#include "kernels/projection/project_constraint.h"

namespace malha {

struct Distance {
  static constexpr const char* name = "distance";
  static constexpr Element element = Element::Edges;
  static constexpr int particles = 2;
  static constexpr bool inequality = false;
  static constexpr Strength strength{true, "rigidity", "N/m of a surface, N of a line"};
  static constexpr Filtered filtered = Filtered::Spring;
  static constexpr int rest_values = 1;
  static constexpr Parameter parameter{"rest_scale", 1, 0, false};

  /// l, m: the distance at rest times rest_scale.
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[2], S rest_scale, S (&rest)[1]) {
    const Vector3<S> d = X[0] - X[1];
    rest[0] = sqrt(dot(d, d)) * rest_scale;
  }

  /// C and its gradients times |p0 - p1|, without division. Coincident points have no direction, and a zero gradient.
  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[2], const S* rest, const Mask& valid, Vector3<S> (&grad)[2],
                           S& scale) {
    grad[0] = or_zero(valid, p[0] - p[1]);
    grad[1] = -grad[0];
    scale = sqrt(dot(grad[0], grad[0]));
    return scale * (scale - rest[0]);
  }
};

/// distance_limit: C = (1 + tau) l - |p0 - p1| >= 0, Provot's elongation limit (Graphics Interface 1995) as an
/// inequality: it acts only on edges that are stretched beyond the limit.
struct DistanceLimit {
  static constexpr const char* name = "distance_limit";
  static constexpr Element element = Element::Edges;
  static constexpr int particles = 2;
  static constexpr bool inequality = true;
  static constexpr Strength strength{true, nullptr, nullptr};
  static constexpr Filtered filtered = Filtered::After;
  static constexpr int rest_values = 1;
  static constexpr Parameter parameter{"limit", 0.1, 0, true};

  /// (1 + tau) l, m.
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[2], S limit, S (&rest)[1]) {
    Distance::rest(X, S(1) + limit, rest);
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
