// SPDX-License-Identifier: Apache-2.0
// volume: C = (p1 - p0) . ((p2 - p0) x (p3 - p0)) / 6 - V0, the signed volume of a tetrahedron: an inverted one
// is restored through zero (Müller et al. 2014, "Strain Based Dynamics", section 3).
#pragma once
#include "kernels/projection/project_constraint.h"

namespace malha {

struct Volume {
  static constexpr const char* name = "volume";
  static constexpr Element element = Element::Tetrahedra;
  static constexpr int particles = 4;
  static constexpr bool inequality = false;
  static constexpr Strength strength{true, nullptr, nullptr};
  static constexpr Filtered filtered = Filtered::After;
  static constexpr int rest_values = 1;
  static constexpr Parameter parameter{"rest_scale", 1, 0, true};

  /// V0, m^3: the volume at rest times rest_scale.
  template <class S>
  KERNEL static void rest(const Vector3<S> (&X)[4], S rest_scale, S (&rest)[1]) {
    const S six_times = dot(X[1] - X[0], cross(X[2] - X[0], X[3] - X[0]));
    rest[0] = six_times * rest_scale * S(typename RealOf<S>::type(1.0 / 6));
  }

  /// C and its gradients times 6 / L^2, L the longest edge from p0, so that gradients are of order 1 at any scale.
  /// Collinear particles have no gradient.
  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[4], const S* rest, const Mask& valid, Vector3<S> (&grad)[4],
                           S& scale) {
    const Vector3<S> a = or_zero(valid, p[1] - p[0]), b = or_zero(valid, p[2] - p[0]), c = or_zero(valid, p[3] - p[0]);
    const S L2 = max(max(max(dot(a, a), dot(b, b)), dot(c, c)), S(1e-12));
    const S L = sqrt(L2), per_L = S(1) / L;
    const Vector3<S> u = a * per_L, v = b * per_L, w = c * per_L;
    grad[1] = cross(v, w), grad[2] = cross(w, u), grad[3] = cross(u, v);
    grad[0] = -(grad[1] + grad[2] + grad[3]);
    scale = S(6) * per_L * per_L;
    return L * dot(u, grad[1]) - scale * rest[0];
  }
};

}  // namespace malha
