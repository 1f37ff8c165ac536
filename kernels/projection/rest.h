// SPDX-License-Identifier: Apache-2.0
// Rest values, residuals and energies of constraints in double, for set-up and reports.
#pragma once
#include "kernels/parallel/compute.h"
#include "kernels/projection/project_constraint.h"

namespace malha {

/// Gathers the positions of a constraint's particles. Point: a type with elements 0, 1, 2 (m).
template <class Kind, class Point>
KERNEL void corners(const Point* x, const int* particles, Vector3<double> (&q)[Kind::particles]) {
  for (int j = 0; j < Kind::particles; ++j) {
    const Point& a = x[particles[j]];
    q[j] = {a[0], a[1], a[2]};
  }
}

/// The rest positions of the corners of constraints: those of their particles, or their own.
template <class Point>
struct RestPositions {
  const Point* X;             // of all particles
  const int* particles;       // Kind::particles a constraint
  const Point* own{nullptr};  // Kind::particles a constraint; null: those of the particles
  template <class Kind>
  KERNEL void corners(int c, Vector3<double> (&q)[Kind::particles]) const {
    if (!own) return malha::corners<Kind>(X, particles + c * Kind::particles, q);
    for (int j = 0; j < Kind::particles; ++j) {
      const Point& a = own[c * Kind::particles + j];
      q[j] = {a[0], a[1], a[2]};
    }
  }
};

/// The constants from which the rest values of each constraint of a set are computed: the same of all, or a parameter
/// each.
template <class Kind>
struct Materials {
  Material<Kind> common;
  const double* parameters{nullptr};  // of each constraint; null: the common one
  KERNEL Material<Kind> of(int c) const {
    if constexpr (std::is_same_v<Material<Kind>, double>) return parameters ? parameters[c] : common;
    return common;
  }
};

/// Rest values of constraint c.
template <class Kind, class Point>
KERNEL void rest_values(const RestPositions<Point>& at, int c, const Material<Kind>& material,
                        double (&rest)[Kind::rest_values]) {
  Vector3<double> q[Kind::particles];
  at.template corners<Kind>(c, q);
  Kind::rest(q, material, rest);
}

/// The same of a constraint whose gap is closed, if it closes at a rate (1/s).
template <class Kind, class Point>
KERNEL void closed_rest_values(const RestPositions<Point>& at, int c, const Material<Kind>& material,
                               double per_closing, double (&rest)[Kind::rest_values]) {
  rest_values<Kind>(at, c, material, rest);
  if (closes<Kind>() && per_closing > 0) rest[0] = 0;
}

/// The first rest value, with which the constraint's quantity is compared.
template <class Kind, class Point>
KERNEL double rest_value(const RestPositions<Point>& at, int c, const Material<Kind>& material) {
  double rest[Kind::rest_values];
  rest_values<Kind>(at, c, material, rest);
  return rest[0];
}

struct Residual {
  double count = 0;
  double C2 = 0;          // sum of C^2
  double softened = 0;    // sum of C^2 over the constraint's factor of the compliance
  double strain2 = 0;     // sum of (C / rest)^2
  double strain_max = 0;  // largest |C / rest|
  double degenerate = 0;  // number of movable constraints without gradient, which projections skip
  KERNEL Residual& operator+=(const Residual& o) {
    count += o.count, C2 += o.C2, softened += o.softened, strain2 += o.strain2, degenerate += o.degenerate;
    strain_max = max(strain_max, o.strain_max);
    return *this;
  }
};

/// Residual of a constraint set.
template <class Kind, class Point>
struct MeasureResidual {
  RestPositions<Point> at_rest;
  const Point* x;        // now
  const double* w;       // 1/kg
  const int* particles;  // Kind::particles a constraint
  Materials<Kind> materials;
  const double* softness;  // factor of each constraint's compliance; null: 1
  KERNEL Residual operator()(int c) const {
    constexpr int n = Kind::particles;
    double rest[Kind::rest_values];
    rest_values<Kind>(at_rest, c, materials.of(c), rest);
    Vector3<double> q[n], grad[n];
    corners<Kind>(x, particles + c * n, q);
    double scale, sum = 0, sum_w = 0;
    const double scaled = Kind::evaluate(q, rest, true, grad, scale);
    for (int j = 0; j < n; ++j) sum += dot(grad[j], grad[j]), sum_w += w[particles[c * n + j]];
    const bool flat = Kind::element == Element::Hinges && !(scale > 0) && rest[0] == 0;  // unfolded, as at rest
    const bool degenerate = !(sum > tiny<double>()) && !flat;
    // Coincident points have length 0, which satisfies an inequality.
    const double C = scale > 0 ? scaled / scale : Kind::inequality ? 0 : -rest[0];
    const double violation = Kind::inequality && C > 0 ? 0 : C;  // a satisfied inequality has no residual
    const double strain = rest[0] > 0 ? violation / rest[0] : 0, C2 = violation * violation;
    return {1,
            C2,
            softness ? C2 / softness[c] : C2,
            strain * strain,
            strain < 0 ? -strain : strain,
            degenerate && sum_w > 0 ? 1.0 : 0.0};
  }
};

/// Elastic energy times the compliance, of kinds with a step().
template <class Kind, class Point>
struct MeasureEnergy {
  RestPositions<Point> at_rest;
  const Point* x;        // now
  const int* particles;  // Kind::particles a constraint
  Materials<Kind> materials;
  const double* softness;  // factor of each constraint's compliance; null: 1
  KERNEL Sum operator()(int c) const {
    double rest[Kind::rest_values];
    rest_values<Kind>(at_rest, c, materials.of(c), rest);
    Vector3<double> q[Kind::particles];
    corners<Kind>(x, particles + c * Kind::particles, q);
    const double energy = Kind::energy(q, rest);
    return {softness ? energy / softness[c] : energy};
  }
};

/// Strain and energy of springs.
struct SpringSum {
  Residual lengths;
  double energy = 0;  // J
  KERNEL SpringSum& operator+=(const SpringSum& o) {
    lengths += o.lengths;
    energy += o.energy;
    return *this;
  }
};

/// Point: a type with elements 0, 1, 2 (m); Ends: one with elements 0 and 1, points.
template <class Point, class Ends>
struct MeasureSpring {
  const Point* x;
  const Ends* ends;
  const double *stiffness, *rest;  // N/m, m
  KERNEL SpringSum operator()(int s) const {
    const Point &a = x[ends[s][0]], &b = x[ends[s][1]];
    const Vector3<double> d{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    const double length = sqrt(dot(d, d)), C = length - rest[s], strain = rest[s] > 0 ? C / rest[s] : 0;
    return {{1, C * C, C * C, strain * strain, strain < 0 ? -strain : strain, length > 0 ? 0.0 : 1.0},
            stiffness[s] * C * C / 2};
  }
};

}  // namespace malha
