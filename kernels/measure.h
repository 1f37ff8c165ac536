// Sums over the particles for reports.
#pragma once
#include "kernels/particles.h"

namespace malha {

struct Motion {
  double momentum[3] = {}, angular[3] = {};  // kg m/s, kg m^2/s about the origin
  double kinetic = 0, potential = 0;         // J
  double speed2_max = 0;                     // m^2/s^2
  KERNEL Motion& operator+=(const Motion& o) {
    for (int k = 0; k < 3; ++k) momentum[k] += o.momentum[k], angular[k] += o.angular[k];
    kinetic += o.kinetic, potential += o.potential;
    speed2_max = larger(speed2_max, o.speed2_max);
    return *this;
  }
};

/// Of the movable particles; the potential is that of gravity, -m g . x.
template <class R>
struct MeasureMotion {
  Particles<R> particles;
  Vector3<double> gravity;
  KERNEL Motion operator()(int i) const {
    const R w = particles.w[i];
    if (!(w > R(0))) return {};
    const double m = 1.0 / double(w);
    const Vector3<R> a = particles.x[i], b = particles.v[i];
    const Vector3<double> x{a.x, a.y, a.z}, v{b.x, b.y, b.z};
    const Vector3<double> L = cross(x, v * m);
    const double v2 = dot(v, v);
    return {{m * v.x, m * v.y, m * v.z}, {L.x, L.y, L.z}, m * v2 / 2, -m * dot(gravity, x), v2};
  }
};

}  // namespace malha
