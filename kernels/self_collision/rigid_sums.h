// SPDX-License-Identifier: Apache-2.0
// What particles have of momenta and energy before and after they are held back, and a rigid motion that is added to
// their velocities.
#pragma once
#include "kernels/forces/angular_velocity.h"
#include "kernels/measure/motion_energy.h"
#include "kernels/self_collision/truncate.h"

namespace malha {

/// Masses, and times them places, velocities, angular momenta and squared speeds, about one place (kg, kg m, kg m/s, kg
/// m^2/s, twice J).
struct MotionSums {
  double mass = 0, x[3] = {}, v[3] = {}, L[3] = {}, square = 0;
  KERNEL void add(double m, const Vector3<double>& r, const Vector3<double>& u) {
    const Vector3<double> spin = cross(r, u);
    mass += m, square += m * dot(u, u);
    x[0] += m * r.x, x[1] += m * r.y, x[2] += m * r.z;
    v[0] += m * u.x, v[1] += m * u.y, v[2] += m * u.z;
    L[0] += m * spin.x, L[1] += m * spin.y, L[2] += m * spin.z;
  }
  KERNEL MotionSums& operator+=(const MotionSums& o) {
    mass += o.mass, square += o.square;
    for (int k = 0; k < 3; ++k) x[k] += o.x[k], v[k] += o.v[k], L[k] += o.L[k];
    return *this;
  }
};

/// Of the same particles, and their inertia after it about that place (kg m^2: xx, yy, zz, xy, xz, yz).
struct HeldSums {
  MotionSums before, after;
  double I[6] = {};
  int changed = 0;  // whether any of them was
  double pins = 0;  // the farthest that any of those that are pinned went, m
  KERNEL HeldSums& operator+=(const HeldSums& o) {
    before += o.before, after += o.after, changed |= o.changed, pins = max(pins, o.pins);
    for (int k = 0; k < 6; ++k) I[k] += o.I[k];
    return *this;
  }
};

/// p - x0 before any is held, m, and how fast it was predicted, m/s.
template <class R>
struct NoteMotion {
  Points<R> v;
  Trajectories<R> motions;
  Vec4<R>* before;
  KERNEL void operator()(int i) const {
    const Vector3<R> d = motions.moved[i].xyz(), u = v[i];
    before[i] = {d.x, d.y, d.z, sqrt(dot(u, u))};
  }
};

/// In place of that motion, once all are held, what this has changed of it.
template <class R>
struct NoteChange {
  Displaced<R> p;
  ScatteredPoints<R> x0;
  Vector3<R> origin;  // m, of x0
  Vec4<R>* before;
  KERNEL void operator()(int i) const { before[i].set(p.displacement_from(i, x0[i], origin) - before[i].xyz()); }
};

/// Of each run of particles, from their state at the end of the substep.
template <class R>
struct SumHeld {
  Particles<R> particles;
  ScatteredPoints<R> x0;
  Vector3<R> origin;      // m, of x0
  const Vec4<R>* before;  // see NoteChange
  double per_dt;          // 1/s
  const ParticleRun* runs;
  HeldSums* sums;
  KERNEL void operator()(int r) const {
    HeldSums sum;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) add(i, sum);
    sums[r] = sum;
  }

 private:
  KERNEL void add(int i, HeldSums& sum) const {
    const R w = particles.w[i];
    const Vector3<R> change = before[i].xyz();
    const Vector3<double> v = in_double(particles.v[i]), first = in_double(x0[0]), start = in_double(x0[i]),
                          x = particles.p.exact_start(i) - in_double(origin);
    if (!(w > R(0))) sum.pins = max(sum.pins, norm(x - start));
    if (!(w > R(0)) || !(dot(v, v) < double(INFINITY))) return;
    sum.changed |= same(change, {R(0), R(0), R(0)}) ? 0 : 1;
    const double m = 1 / double(w);
    const Vector3<double> r = x - first;
    sum.before.add(m, start - first, v - in_double(change) * per_dt);
    sum.after.add(m, r, v);
    add_inertia(sum.I, m, r);
  }
};

/// v = kept v + velocity + omega x (x - centre), the centre about the same place, of the runs that are `chosen`.
template <class R>
struct AddRigidGain {
  Particles<R> particles;
  ScatteredPoints<R> x0;
  Vector3<R> origin;  // m, of x0
  const ParticleRun* runs;
  const int* chosen;
  double kept;
  Vector3<double> centre, velocity, omega;
  KERNEL void operator()(int r) const {
    if (!chosen[r]) return;
    const Vector3<double> from = in_double(origin) + in_double(x0[0]) + centre;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) {
      if (!(particles.w[i] > R(0))) continue;
      const Vector3<double> arm = particles.p.exact_start(i) - from;
      particles.v.set(i, rounded<R>(in_double(particles.v[i]) * kept + velocity + cross(omega, arm)));
    }
  }
};

/// None of the runs that are `chosen` is faster than `most`, unless it was before.
template <class R>
struct LimitSpeed {
  Particles<R> particles;
  const Vec4<R>* before;  // see NoteChange
  const ParticleRun* runs;
  const int* chosen;
  double most;  // m/s
  KERNEL void operator()(int r) const {
    if (!chosen[r]) return;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) {
      const Vector3<double> v = in_double(particles.v[i]);
      const double speed = norm(v), allowed = max(most, double(before[i].w));
      if (particles.w[i] > R(0) && speed > allowed) particles.v.set(i, rounded<R>(v * (allowed / speed)));
    }
  }
};

/// Of the bodies that are about to be held: their motion, and how far from the origin of x0 they are.
struct HeldMotion {
  MeanMotion mean;      // weighted by masses
  double farthest = 0;  // m
};

/// Of each run; nothing of those without a particle that is to be held.
template <class R>
struct SumHeldMotion {
  Trajectories<R> motions;
  const MotionState* held;
  const ParticleRun* runs;
  HeldMotion* sums;
  KERNEL void operator()(int r) const {
    HeldMotion sum;
    bool any = false;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) {
      const Vector3<double> d = in_double(motions.moved[i].xyz()), x = in_double(motions.x0[i].xyz());
      if (!(motions.moved[i].w > R(0)) || !(dot(d, d) < double(INFINITY))) continue;
      const double m = 1 / double(motions.moved[i].w);
      sum.mean += {{m * d.x, m * d.y, m * d.z}, m};
      sum.farthest = max(sum.farthest, max(abs(x.x), max(abs(x.y), abs(x.z))));
      any = any || held[i] == MotionState::Truncating;
    }
    sums[r] = any ? sum : HeldMotion{};
  }
};

}  // namespace malha
