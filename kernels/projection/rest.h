// SPDX-License-Identifier: Apache-2.0
// Rest values and residuals of constraints in double, for set-up and for reports, whatever the solver's precision.
#pragma once
#include "kernels/parallel/reductions.h"
#include "kernels/projection/project_constraint.h"

namespace malha {

/// Point: a type with elements 0, 1, 2 (m). `particles`: those of one constraint.
template <class Kind, class Point>
KERNEL void corners(const Point* x, const int* particles, Vector3<double> (&q)[Kind::particles]) {
  for (int j = 0; j < Kind::particles; ++j) {
    const Point& a = x[particles[j]];
    q[j] = {a[0], a[1], a[2]};
  }
}

/// A constraint's rest values from the rest positions.
template <class Kind, class Point>
KERNEL void rest_values(const Point* X, const int* particles, double parameter, double (&rest)[Kind::numbers]) {
  Vector3<double> q[Kind::particles];
  corners<Kind>(X, particles, q);
  Kind::rest(q, parameter, rest);
}

/// The first of them: what the constraint's own quantity is compared with.
template <class Kind, class Point>
KERNEL double rest_value(const Point* X, const int* particles, double parameter) {
  double rest[Kind::numbers];
  rest_values<Kind>(X, particles, parameter, rest);
  return rest[0];
}

struct Residual {
  double count = 0;
  double C2 = 0;          // sum of C^2
  double softened = 0;    // sum of C^2 over the constraint's own part of its compliance
  double strain2 = 0;     // sum of (C / rest)^2
  double strain_max = 0;  // largest |C / rest|
  double degenerate = 0;  // movable, but without a gradient: skipped by the projection
  KERNEL Residual& operator+=(const Residual& o) {
    count += o.count, C2 += o.C2, softened += o.softened, strain2 += o.strain2, degenerate += o.degenerate;
    strain_max = max(strain_max, o.strain_max);
    return *this;
  }
};

/// How well the constraints of a set are met.
template <class Kind, class Point>
struct MeasureResidual {
  const Point *X, *x;    // at rest, and now
  const double* w;       // 1/kg
  const int* particles;  // Kind::particles a constraint
  double parameter;
  const double* softness;  // each constraint's own part of its compliance; null: 1
  KERNEL Residual operator()(int c) const {
    constexpr int n = Kind::particles;
    double rest[Kind::numbers];
    rest_values<Kind>(X, particles + c * n, parameter, rest);
    Vector3<double> q[n], grad[n];
    corners<Kind>(x, particles + c * n, q);
    double scale, sum = 0, sum_w = 0;
    const double scaled = Kind::evaluate(q, rest, true, grad, scale);
    for (int j = 0; j < n; ++j) sum += dot(grad[j], grad[j]), sum_w += w[particles[c * n + j]];
    const bool met = Kind::element == Element::Hinges && !(scale > 0) && rest[0] == 0;  // no fold, as at rest
    const bool degenerate = !(sum > tiny<double>()) && !met;
    // Coincident points: as short as can be, which an inequality allows.
    const double C = scale > 0 ? scaled / scale : Kind::inequality ? 0 : -rest[0];
    const double violation = Kind::inequality && C > 0 ? 0 : C;  // an inequality that holds has no residual
    const double strain = rest[0] > 0 ? violation / rest[0] : 0, C2 = violation * violation;
    return {1,
            C2,
            softness ? C2 / softness[c] : C2,
            strain * strain,
            strain < 0 ? -strain : strain,
            degenerate && sum_w > 0 ? 1.0 : 0.0};
  }
};

/// The elastic energy times the compliance, of kinds with a step of their own.
template <class Kind, class Point>
struct MeasureEnergy {
  const Point *X, *x;    // at rest, and now
  const int* particles;  // Kind::particles a constraint
  double parameter;
  const double* softness;  // each constraint's own part of its compliance; null: 1
  KERNEL Sum operator()(int c) const {
    double rest[Kind::numbers];
    rest_values<Kind>(X, particles + c * Kind::particles, parameter, rest);
    Vector3<double> q[Kind::particles];
    corners<Kind>(x, particles + c * Kind::particles, q);
    const double energy = Kind::energy(q, rest);
    return {softness ? energy / softness[c] : energy};
  }
};

}  // namespace malha
