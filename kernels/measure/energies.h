// SPDX-License-Identifier: Apache-2.0
// Sums over the particles for reports.
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

struct Motion {
  double momentum[3] = {}, angular[3] = {};  // kg m/s, kg m^2/s about the origin
  double mass = 0, moment[3] = {};           // kg, kg m: the sum of m x
  double kinetic = 0, potential = 0;         // J
  double speed2_max = 0;                     // m^2/s^2
  KERNEL Motion& operator+=(const Motion& o) {
    for (int k = 0; k < 3; ++k) momentum[k] += o.momentum[k], angular[k] += o.angular[k], moment[k] += o.moment[k];
    mass += o.mass;
    kinetic += o.kinetic, potential += o.potential;
    speed2_max = max(speed2_max, o.speed2_max);
    return *this;
  }
};

/// Sums over the movable particles; potential energy is that of gravity, -m g . x.
template <class R>
struct MeasureMotion {
  Particles<R> particles;
  Vector3<double> gravity;
  KERNEL Motion operator()(int i) const {
    const R w = particles.w[i];
    if (!(w > R(0))) return {};
    const double m = 1.0 / double(w);
    const Vector3<double> x = in_double(particles.x[i]), v = in_double(particles.v[i]);
    const Vector3<double> L = cross(x, v * m);
    const double v2 = dot(v, v);
    return {{m * v.x, m * v.y, m * v.z},
            {L.x, L.y, L.z},
            m,
            {m * x.x, m * x.y, m * x.z},
            m * v2 / 2,
            -m * dot(gravity, x),
            v2};
  }
};

/// Sum of squared strains, and the largest strain.
struct LengthSum {
  double strain2 = 0, most = 0;
  int at = -1;
  KERNEL LengthSum& operator+=(const LengthSum& o) {
    strain2 += o.strain2;
    if (o.most > most) most = o.most, at = o.at;
    return *this;
  }
};

/// |l - l0| / l0 of a length between two points. Point: a type with elements 0, 1, 2 (m).
template <class Point>
struct MeasureLength {
  const Point *X, *x;    // at rest, and now
  const int* ends;       // two a length
  double scale;          // of l0, over the length in X
  const double* scales;  // of the l0 of each; null: `scale`
  const double* rest;    // l0 of each, m; null: by X
  const Point* own;      // the ends of each at rest, two a length; null: by X
  KERNEL LengthSum operator()(int c) const {
    const int a = ends[2 * c], b = ends[2 * c + 1];
    const Point &A = own ? own[2 * c] : X[a], &B = own ? own[2 * c + 1] : X[b];
    const double of = scales ? scales[c] : scale;
    const double l02 = rest ? rest[c] * rest[c] : of * of * squared(A, B);
    if (!(l02 > 0)) return {};
    const double strain = sqrt(squared(x[a], x[b]) / l02) - 1, size = strain < 0 ? -strain : strain;
    return {size * size, size, c};
  }
  KERNEL static double squared(const Point& a, const Point& b) {
    const Vector3<double> d{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return dot(d, d);
  }
};

struct Volumes {
  double now = 0, at_rest = 0;  // m^3, summed
  double inverted = 0;          // tetrahedra of negative volume
  KERNEL Volumes& operator+=(const Volumes& o) {
    now += o.now, at_rest += o.at_rest, inverted += o.inverted;
    return *this;
  }
};

/// Volume of a tetrahedron. Point: a type with elements 0, 1, 2 (m).
template <class Point>
struct MeasureVolume {
  const Point *X, *x;  // at rest, and now
  const int* corners;  // four a tetrahedron
  KERNEL Volumes operator()(int t) const {
    const double now = volume(x, corners + 4 * t), at_rest = volume(X, corners + 4 * t);
    return {now, at_rest, now < 0 ? 1.0 : 0.0};
  }
  KERNEL static double volume(const Point* points, const int* of) {
    const Vector3<double> o = at(points[of[0]]);
    return dot(at(points[of[1]]) - o, cross(at(points[of[2]]) - o, at(points[of[3]]) - o)) / 6;
  }
  KERNEL static Vector3<double> at(const Point& a) { return {a[0], a[1], a[2]}; }
};

}  // namespace malha
