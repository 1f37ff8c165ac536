// What all particles that collide have of momenta, and a motion of all of them as one body.
#pragma once
#include "kernels/contact.h"
#include "kernels/vec.h"

namespace malha {

/// Of free particles that go from x to p, about the first one's x: masses, and times them x, p, and x_i p_j (kg, kg m,
/// kg m^2).
struct RigidSums {
  double mass = 0, x[3] = {}, p[3] = {}, xp[9] = {};
  double farthest = 0;  // of their coordinates in the world, m
  KERNEL RigidSums& operator+=(const RigidSums& o) {
    mass += o.mass, farthest = larger(farthest, o.farthest);
    for (int k = 0; k < 3; ++k) x[k] += o.x[k], p[k] += o.p[k];
    for (int k = 0; k < 9; ++k) xp[k] += o.xp[k];
    return *this;
  }
};

template <class R>
struct SumRigid {
  Points<R> p;
  ScatteredPoints<R> x0;
  const R* w;
  const unsigned char* takes_part;
  KERNEL RigidSums operator()(int i) const {
    const Vector3<R> a = x0[i] - x0[0], b = p[i] - x0[0];
    RigidSums sums;
    if (!takes_part[i] || !(w[i] > R(0)) || !((b.x + b.y + b.z) * R(0) == R(0))) return sums;
    const double m = 1 / double(w[i]), from[3] = {double(a.x), double(a.y), double(a.z)};
    const double to[3] = {double(b.x), double(b.y), double(b.z)};
    sums.mass = m;
    sums.farthest = larger(double(magnitude(p[i].x)), larger(double(magnitude(p[i].y)), double(magnitude(p[i].z))));
    for (int k = 0; k < 3; ++k) {
      sums.x[k] = m * from[k], sums.p[k] = m * to[k];
      for (int j = 0; j < 3; ++j) sums.xp[3 * k + j] = m * from[k] * to[j];
    }
    return sums;
  }
};

/// p = to + turn (p - from), about the same place, of all that take part.
template <class R>
struct MoveRigidly {
  Points<R> p;
  ScatteredPoints<R> x0;
  const unsigned char* takes_part;
  Vector3<R> from, to, turn[3];  // turn: rows
  KERNEL void operator()(int i) const {
    if (!takes_part[i]) return;
    const Vector3<R> r = p[i] - x0[0] - from;
    p.set(i, x0[0] + to + Vector3<R>{dot(turn[0], r), dot(turn[1], r), dot(turn[2], r)});
  }
};

}  // namespace malha
