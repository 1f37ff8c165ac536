// How well constraints are met, for reports: a pass over one batch, one constraint an item.
#pragma once
#include "kernels/constraint.h"

namespace malha {

struct Residual {
  double count = 0;
  double C2 = 0;          // sum of C^2
  double strain2 = 0;     // sum of (C / rest)^2
  double strain_max = 0;  // largest |C / rest|
  double degenerate = 0;  // movable, but without a gradient: skipped by the projection
  KERNEL Residual& operator+=(const Residual& o) {
    count += o.count, C2 += o.C2, strain2 += o.strain2, degenerate += o.degenerate;
    strain_max = larger(strain_max, o.strain_max);
    return *this;
  }
};

template <class Kind, class R>
struct MeasureResidual {
  const Vec4<R>* x;  // positions
  const Vec4<R>* p;  // for w
  const int* index[Kind::particles];
  const R* rest;
  int begin;
  KERNEL Residual operator()(int item) const {
    constexpr int n = Kind::particles;
    const int at = begin + item;
    Vector3<R> q[n], grad[n];
    R sum_w = 0;
    for (int j = 0; j < n; ++j) {
      q[j] = x[index[j][at]].xyz();
      sum_w += p[index[j][at]].w;
    }
    const R C = Kind::evaluate(q, rest[at], grad);
    R sum = 0;
    for (int j = 0; j < n; ++j) sum += dot(grad[j], grad[j]);
    // An inequality that holds has no residual.
    const double violation = Kind::inequality && C > R(0) ? 0.0 : double(C);
    const double strain = rest[at] > R(0) ? violation / double(rest[at]) : 0.0;
    return {1, violation * violation, strain * strain, strain < 0 ? -strain : strain,
            sum_w > R(0) && !(sum > tiny<R>()) ? 1.0 : 0.0};
  }
};

/// A constraint's rest value from the rest positions, in double.
template <class Kind>
struct MeasureRest {
  const Vector3<double>* X;
  const int* particles;  // Kind::particles a constraint
  double parameter;
  double* rest;
  KERNEL void operator()(int c) const {
    Vector3<double> q[Kind::particles];
    for (int j = 0; j < Kind::particles; ++j) q[j] = X[particles[c * Kind::particles + j]];
    rest[c] = Kind::rest(q, parameter);
  }
};

}  // namespace malha
