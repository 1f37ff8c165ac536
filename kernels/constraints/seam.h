// SPDX-License-Identifier: Apache-2.0
// seam: C = |p0 - p1| - c r, and surface_attachment: C = |p0 - sum w_k p_k| - c r, k = 1 .. 3. They join two bodies, or
// two parts of one, at two particles or at a particle and a point of a triangle. r is the gap at the start; the factor
// c of their set falls from 1 to 0 while a seam closes (kernels/projection/project_constraint.h), and both are one
// place then. Their elements are pairs of the scene's seams rather than parts of a mesh.
//
// Both are lengths, whose direction turns with the bodies. Where they are closed they have no length at the start of a
// substep, and move along the current gradient: that exerts no torque, because both points are at one place.
#pragma once
#include "kernels/constraints/distance.h"
#include "kernels/geometry/closest_point.h"

namespace malha {

struct Seam : Distance {
  static constexpr const char* name = "seam";
  static constexpr Element element = Element::SewnPairs;
  static constexpr Strength strength{true, nullptr, nullptr};
  static constexpr Filtered filtered = Filtered::After;
  static constexpr Parameter parameter{"gap_scale", 1, 0, true};
  static constexpr bool closes = true;
};

struct SurfaceAttachment {
  static constexpr const char* name = "surface_attachment";
  static constexpr Element element = Element::AttachedPoints;
  static constexpr int particles = 4;
  static constexpr bool inequality = false;
  static constexpr Strength strength{true, nullptr, nullptr};
  static constexpr Filtered filtered = Filtered::After;
  static constexpr int rest_values = 3;
  static constexpr Parameter parameter{"gap_scale", 1, 0, true};
  static constexpr bool closes = true;
  /// A closed attachment has a gap of rounding errors at the start of the substep, in any direction.
  static constexpr double min_turn_cosine = 0.97;

  /// r (m), the distance of the particle from the triangle times gap_scale; and the weights of the triangle's second
  /// and third corner at the point that is closest to it. Those of the three corners sum to 1.
  KERNEL static void rest(const Vector3<double> (&X)[4], double gap_scale, double (&rest)[3]) {
    const Vector3<double> b = X[2] - X[1], c = X[3] - X[1], p = X[0] - X[1];
    const Vector3<double> weights = closest_on_triangle(b, c, p);
    const Vector3<double> gap = p - b * weights.y - c * weights.z;
    rest[0] = sqrt(dot(gap, gap)) * gap_scale, rest[1] = weights.y, rest[2] = weights.z;
  }

  /// C and its gradients times the gap, without division.
  template <class S, class Mask>
  KERNEL static S evaluate(const Vector3<S> (&p)[4], const S* rest, const Mask& valid, Vector3<S> (&grad)[4],
                           S& scale) {
    const S w2 = rest[1], w3 = rest[2], w1 = S(1) - w2 - w3;
    const Vector3<S> gap = (p[0] - p[1]) - (p[2] - p[1]) * w2 - (p[3] - p[1]) * w3;
    grad[0] = or_zero(valid, gap), grad[1] = or_zero(valid, gap * -w1);
    grad[2] = or_zero(valid, gap * -w2), grad[3] = or_zero(valid, gap * -w3);
    scale = sqrt(dot(grad[0], grad[0]));
    return scale * (scale - rest[0]);
  }
};

}  // namespace malha
