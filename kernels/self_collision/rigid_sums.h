// SPDX-License-Identifier: Apache-2.0
// Momenta and energy of particles before and after truncation, and the rigid motion that is added to their velocities
// to restore the momenta.
#pragma once
#include "kernels/forces/angular_velocity.h"
#include "kernels/measure/motion_energy.h"
#include "kernels/self_collision/swept_bounds.h"
#include "kernels/self_collision/truncate.h"

namespace malha {

/// Sums over particles, about one point: mass (kg), mass times position (kg m), momentum (kg m/s), angular momentum
/// (kg m^2/s), and twice the kinetic energy (J).
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

/// Sums of the same particles before and after truncation, and their inertia after it about the same point (kg m^2: xx,
/// yy, zz, xy, xz, yz).
struct TruncationSums {
  MotionSums before, after;
  double I[6] = {};
  int changed = 0;  // whether any of them was truncated
  double pins = 0;  // the largest displacement of a pinned particle, m
  KERNEL TruncationSums& operator+=(const TruncationSums& o) {
    before += o.before, after += o.after, changed |= o.changed, pins = max(pins, o.pins);
    for (int k = 0; k < 6; ++k) I[k] += o.I[k];
    return *this;
  }
};

/// Saves p - x0 before truncation (m), and the predicted speed (m/s).
template <class R>
struct SaveMotion {
  Points<R> v;
  Trajectories<R> motions;
  Vec4<R>* saved;
  KERNEL void operator()(int i) const {
    const Vector3<R> d = motions.moved[i].xyz(), u = v[i];
    saved[i] = {d.x, d.y, d.z, sqrt(dot(u, u))};
  }
};

/// Replaces the saved displacements by what truncation has changed of them.
template <class R>
struct ComputeTruncationChange {
  Displaced<R> p;
  Trajectories<R> motions;
  Vec4<R>* saved;
  KERNEL void operator()(int i) const {
    saved[i].set(p.displacement_from(i, motions.x0[i].xyz(), motions.origin) - saved[i].xyz());
  }
};

/// Adjusts particles that a mesh moved from x0 to x before the substep (the lift) and whose displacement was truncated
/// afterwards: the part of the lift that was undone must not count as motion.
template <class R>
struct RemoveUndoneLift {
  Particles<R> particles;
  Trajectories<R> motions;
  KERNEL void operator()(int i) const {
    const Displaced<R>& p = particles.p;
    const Vector3<R> from = motions.x0[i].xyz(), lift = p.start_relative_to(i, from, motions.origin);
    const R squared = dot(lift, lift);
    if (!(particles.w[i] > R(0)) || !(squared > R(0)) || !(squared < R(INFINITY))) return;
    const Vector3<R> displacement = p.displacement_from(i, from, motions.origin);
    const R kept = min(max(dot(lift, displacement) / squared, R(0)), R(1));
    if (!(kept < R(1))) return;
    p.set_start(i, in_double(motions.origin) + in_double(from) + in_double(lift * kept));
    p.set_displacement_from(i, from, motions.origin, displacement);
  }
};

/// Sums of each run of particles, from their state at the end of the substep.
template <class R>
struct SumTruncation {
  Particles<R> particles;
  Trajectories<R> motions;
  const Vec4<R>* saved;  // see ComputeTruncationChange
  double per_dt;         // 1 / h of the substep, 1/s
  const ParticleRun* runs;
  TruncationSums* sums;
  KERNEL void operator()(int r) const {
    TruncationSums sum;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) add(i, sum);
    sums[r] = sum;
  }

 private:
  KERNEL void add(int i, TruncationSums& sum) const {
    const R w = particles.w[i];
    const Vector3<R> change = saved[i].xyz();
    const Vector3<double> v = in_double(particles.v[i]), first = in_double(motions.x0[0].xyz()),
                          start = in_double(motions.x0[i].xyz()),
                          x = particles.p.exact_start(i) - in_double(motions.origin);
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

/// v = kept v + velocity + omega x (x - centre), the centre relative to the point of the sums.
struct RigidCorrection {
  double kept = 1;
  Vector3<double> centre{0, 0, 0}, velocity{0, 0, 0}, omega{0, 0, 0};  // m, m/s, 1/s
};

/// Applies the correction to the particles in `chosen` runs.
template <class R>
struct AddRigidCorrection {
  Particles<R> particles;
  Trajectories<R> motions;
  const ParticleRun* runs;
  const int* chosen;
  RigidCorrection correction;
  KERNEL void operator()(int r) const {
    if (!chosen[r]) return;
    const auto& [kept, centre, velocity, omega] = correction;
    const Vector3<double> from = in_double(motions.origin) + in_double(motions.x0[0].xyz()) + centre;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) {
      if (!(particles.w[i] > R(0))) continue;
      const Vector3<double> arm = particles.p.exact_start(i) - from;
      particles.v.set(i, rounded<R>(in_double(particles.v[i]) * kept + velocity + cross(omega, arm)));
    }
  }
};

/// Limits the speed of the particles in `chosen` runs to max_speed, or to the predicted speed where that was higher.
template <class R>
struct LimitSpeed {
  Particles<R> particles;
  const Vec4<R>* saved;  // see SaveMotion
  const ParticleRun* runs;
  const int* chosen;
  double max_speed;  // m/s
  KERNEL void operator()(int r) const {
    if (!chosen[r]) return;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) {
      const Vector3<double> v = in_double(particles.v[i]);
      const double speed = norm(v), allowed = max(max_speed, double(saved[i].w));
      if (particles.w[i] > R(0) && speed > allowed) particles.v.set(i, rounded<R>(v * (allowed / speed)));
    }
  }
};

/// Weighted mean of motions.
struct MeanMotion {
  double sum[3] = {}, weight = 0;
  KERNEL MeanMotion& operator+=(const MeanMotion& o) {
    for (int k = 0; k < 3; ++k) sum[k] += o.sum[k];
    weight += o.weight;
    return *this;
  }
  /// The mean; 0 without any motion.
  KERNEL Vector3<double> value() const {
    const double per = weight > 0 ? 1 / weight : 0;
    return {sum[0] * per, sum[1] * per, sum[2] * per};
  }
};

/// Motion of the bodies that are about to be truncated, and their largest distance from the origin of x0.
struct TruncatedMotion {
  MeanMotion mean;      // weighted by masses
  double farthest = 0;  // m
};

/// Sums the motion of each run; nothing of runs without a particle that is Truncating.
template <class R>
struct SumTruncatedMotion {
  Trajectories<R> motions;
  const MotionState* states;
  const ParticleRun* runs;
  TruncatedMotion* sums;
  KERNEL void operator()(int r) const {
    TruncatedMotion sum;
    bool any = false;
    for (int i = runs[r].first; i < runs[r].first + runs[r].count; ++i) {
      const Vector3<double> d = in_double(motions.moved[i].xyz()), x = in_double(motions.x0[i].xyz());
      if (!(motions.moved[i].w > R(0)) || !(dot(d, d) < double(INFINITY))) continue;
      const double m = 1 / double(motions.moved[i].w);
      sum.mean += {{m * d.x, m * d.y, m * d.z}, m};
      sum.farthest = max(sum.farthest, max(abs(x.x), max(abs(x.y), abs(x.z))));
      any = any || states[i] == MotionState::Truncating;
    }
    sums[r] = any ? sum : TruncatedMotion{};
  }
};

}  // namespace malha
