// SPDX-License-Identifier: Apache-2.0
// Strain and energy of springs in double, for reports.
#pragma once
#include "kernels/projection/rest.h"

namespace malha {

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
