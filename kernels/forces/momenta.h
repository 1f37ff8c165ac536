// SPDX-License-Identifier: Apache-2.0
// Momenta of bodies, summed over ranges of particles, and rigid motions that are added to their particles.
#pragma once
#include "kernels/forces/angular_velocity.h"
#include "kernels/forces/integrate.h"
#include "kernels/projection/patch.h"
#include "kernels/simd/for_each_pack.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Particles first .. first + count - 1 of one connected body, whose first particle is `reference`.
struct ParticleRange {
  int first, count, body, reference;
};

/// Sums over the particles of a range, relative to the position and velocity of the body's first particle, so that
/// rounding is relative to the size of the body, wherever it is. Pinned particles do not count.
struct MomentaSum {
  static constexpr int kMomenta = 10, kAll = 16;  // numbers without and with the inertia
  double place[3], velocity[3];                   // of that particle, m, m/s
  double moments[kAll];
  KERNEL double m() const { return moments[0]; }           // kg
  KERNEL const double* r() const { return moments + 1; }   // m r, kg m
  KERNEL const double* u() const { return moments + 4; }   // m u, kg m/s
  KERNEL const double* L() const { return moments + 7; }   // r x m u, kg m^2/s
  KERNEL const double* I() const { return moments + 10; }  // kg m^2: xx, yy, zz, xy, xz, yz
};

/// Computes MomentaSum of a range from x and v or, if `projected`, as if the substep ended at the current p. `inertia`:
/// includes it. N: type of the sums. Sixteen lanes are summed separately, whatever the width of a pack, so that every
/// instruction set gives the same bits. On a device each lane has a thread.
template <class R, class N, bool projected, bool inertia>
struct MeasureMomenta {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  static constexpr int n = inertia ? MomentaSum::kAll : MomentaSum::kMomenta;
  static constexpr size_t kBytes = n * kSlotPack * sizeof(N);  // of fast memory
  Particles<R> particles;
  const ParticleRange* ranges;
  MomentaSum* sums;
  N dt, per_dt;  // s, 1/s, of the substep

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<N, typename Group::Isa>;
    constexpr int lanes = kLanes<N, typename Group::Isa>;
    const ParticleRange range = ranges[group.index];
    const int whole = range.count / kSlotPack * kSlotPack;
    const Vector3<R> x0 = particles.x[range.reference], v0 = particles.v[range.reference];
    N* const of_lane = static_cast<N*>(group.memory);  // kSlotPack per sum
    group.for_each(kSlotPack / lanes, [&](int pack) KERNEL_LAMBDA {
      const int first = pack * lanes;
      S sum[n];
      for (int k = 0; k < n; ++k) sum[k] = S(N(0));
      KERNEL_ROLLED
      for (int i = first; i < whole; i += kSlotPack) add(x0, v0, range.first + i, sum);
      for (int k = 0; k < n; ++k) store(sum[k], of_lane + k * kSlotPack + first);
    });
    group.for_each(range.count - whole, [&](int left) KERNEL_LAMBDA {
      N sum[n];
      for (int k = 0; k < n; ++k) sum[k] = of_lane[k * kSlotPack + left];
      add(x0, v0, range.first + whole + left, sum);
      for (int k = 0; k < n; ++k) of_lane[k * kSlotPack + left] = sum[k];
    });
    MomentaSum& to = sums[group.index];
    group.for_each(n, [&](int k) KERNEL_LAMBDA {
      double all = 0;
      for (int l = 0; l < kSlotPack; ++l) all += of_lane[k * kSlotPack + l];
      to.moments[k] = all;
    });
    group.for_each(1, [&](int) KERNEL_LAMBDA {
      to.place[0] = x0.x, to.place[1] = x0.y, to.place[2] = x0.z;
      to.velocity[0] = v0.x, to.velocity[1] = v0.y, to.velocity[2] = v0.z;
    });
  }

 private:
  template <class S>
  KERNEL void add(const Vector3<R>& x0, const Vector3<R>& v0, int i, S (&sum)[n]) const {
    const S zero(N(0));
    S w;
    load(particles.w + i, w);
    const S m = select(w > zero, S(N(1)) / w, zero);
    const Vector3<S> x = load_points<S>(particles.x, i);
    Vector3<S> v = load_points<S>(particles.v, i);
    Vector3<S> r = x - all<S>(x0);
    if constexpr (projected) {
      const Vector3<S> d = load_points<S>(particles.p.d, i);
      v = velocity_from_positions(v, d, S(dt), S(per_dt));
      r = r + d;
    }
    const Vector3<S> u = (v - all<S>(v0)) * m;
    const Vector3<S> L = cross(r, u), mr = r * m;
    const S of[MomentaSum::kAll] = {m,
                                    mr.x,
                                    mr.y,
                                    mr.z,
                                    u.x,
                                    u.y,
                                    u.z,
                                    L.x,
                                    L.y,
                                    L.z,
                                    mr.y * r.y + mr.z * r.z,
                                    mr.x * r.x + mr.z * r.z,
                                    mr.x * r.x + mr.y * r.y,
                                    -mr.x * r.y,
                                    -mr.x * r.z,
                                    -mr.y * r.z};
    for (int k = 0; k < n; ++k) sum[k] = sum[k] + of[k];
  }
  template <class S>
  KERNEL static Vector3<S> all(const Vector3<R>& a) {
    return {S(N(a.x)), S(N(a.y)), S(N(a.z))};
  }
};

/// Momenta of a body. They are not used for bodies that are wholly pinned.
struct Momenta {
  double mass = 0, place[3] = {}, centre[3] = {};  // kg; m; m, from that place
  double linear[3] = {};                           // kg m/s
  SpinSum spin;                                    // about the centre of mass

  Momenta() = default;
  KERNEL explicit Momenta(const MomentaSum& sum) {
    const double m = sum.m(), per = m > 0 ? 1 / m : 0, *r = sum.r(), *u = sum.u();
    const double c[3] = {r[0] * per, r[1] * per, r[2] * per};
    mass = m;
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      place[k] = sum.place[k], centre[k] = c[k];
      linear[k] = u[k] + m * sum.velocity[k];
      spin.L[k] = sum.L()[k] - (c[i] * u[j] - c[j] * u[i]);
      spin.I[k] = sum.I()[k] - (r[i] * c[i] + r[j] * c[j]);
    }
    spin.I[3] = sum.I()[3] + r[0] * c[1];
    spin.I[4] = sum.I()[4] + r[0] * c[2];
    spin.I[5] = sum.I()[5] + r[1] * c[2];
  }
};

/// A body and its momenta between two measurements.
struct MeasuredBody {
  int begin, end;  // its ranges
  int excluded;    // from the correction
  Momenta now;
  double linear[3], spin[3];            // at the start, kg m/s, kg m^2/s
  double lost_linear[3], lost_spin[3];  // since the last correction
};

/// Purpose of a measurement.
enum class Measured { Start, Loss, Now };

/// Adds up the sums of each body's ranges, in runs that depend on their number alone, and stores its momenta.
struct StoreMomenta {
  using Shared = void;
  static constexpr int kMostThreads = 128;
  MomentaSum* sums;
  MeasuredBody* bodies;
  int numbers;  // of a sum
  Measured what;
  Vector3<double> gained;  // velocity by gravity since the start, m/s

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    MeasuredBody& body = bodies[group.index];
    const int runs = (body.end - body.begin + kRun - 1) / kRun;
    if (body.end - body.begin > 1)
      group.for_each(runs * numbers, [&](int i) KERNEL_LAMBDA {
        const int first = body.begin + i / numbers * kRun;
        join(i % numbers, first, first + kRun < body.end ? first + kRun : body.end, 1);
      });
    if (runs > 1) group.for_each(numbers, [&](int k) KERNEL_LAMBDA { join(k, body.begin, body.end, kRun); });
    group.for_each(1, [&](int) KERNEL_LAMBDA { note(Momenta(sums[body.begin]), body); });
  }

 private:
  static constexpr int kRun = 32;  // ranges

  KERNEL void join(int k, int begin, int end, int step) const {
    double sum = sums[begin].moments[k];
    for (int s = begin + step; s < end; s += step) sum += sums[s].moments[k];
    sums[begin].moments[k] = sum;
  }
  KERNEL void note(const Momenta& now, MeasuredBody& body) const {
    const double per_mass[3] = {gained.x, gained.y, gained.z};
    body.now = now;
    for (int k = 0; k < 3; ++k) {
      if (what == Measured::Start) body.linear[k] = now.linear[k], body.spin[k] = now.spin.L[k];
      if (what != Measured::Loss) continue;
      body.lost_linear[k] += body.linear[k] + now.mass * per_mass[k] - now.linear[k];
      body.lost_spin[k] += body.spin[k] - now.spin.L[k];
    }
  }
};

/// v + omega x r, r from the point place + centre, whose parts are both of low precision.
template <class R>
struct RigidMotion {
  Vector3<R> place, centre;    // m
  Vector3<R> velocity, omega;  // m/s, 1/s

  RigidMotion() = default;
  /// The rigid motion of a body with these momenta.
  KERNEL RigidMotion(const Momenta& body, const double (&linear)[3], const double (&spin)[3])
      : place(to_R(body.place, 1)),
        centre(to_R(body.centre, 1)),
        velocity(to_R(linear, body.mass > 0 ? 1 / body.mass : 0)) {
    SpinSum sum = body.spin;
    for (int k = 0; k < 3; ++k) sum.L[k] = spin[k];
    omega = rounded<R>(angular_velocity(sum));
  }
  /// The velocity at x.
  template <class S>
  KERNEL Vector3<S> at(const Vector3<S>& x) const {
    const Vector3<S> r = x - all<S>(place) - all<S>(centre);
    return all<S>(velocity) + cross(all<S>(omega), r);
  }

 private:
  KERNEL static Vector3<R> to_R(const double* a, double per) { return {R(a[0] * per), R(a[1] * per), R(a[2] * per)}; }
  template <class S>
  KERNEL static Vector3<S> all(const Vector3<R>& a) {
    return {S(a.x), S(a.y), S(a.z)};
  }
};

/// The rigid motion that restores the momenta that each body has lost.
template <class R>
struct ComputeMomentumCorrection {
  MeasuredBody* bodies;
  RigidMotion<R>* motions;
  KERNEL void operator()(int b) const {
    MeasuredBody& body = bodies[b];
    motions[b] = body.excluded ? RigidMotion<R>{} : RigidMotion<R>(body.now, body.lost_linear, body.lost_spin);
    for (int k = 0; k < 3; ++k) body.lost_linear[k] = body.lost_spin[k] = 0;
  }
};

/// Adds to each particle the rigid motion of its body.
template <class R>
struct AddRigidMotion {
  using Shared = void;
  Particles<R> particles;
  const ParticleRange* ranges;
  const RigidMotion<R>* motions;  // of each body

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const ParticleRange range = ranges[group.index];
    const RigidMotion<R> motion = motions[range.body];
    for_each_pack_once<R>(group, range.count, [&]<class S>(int n, S) KERNEL_LAMBDA {
      const int i = range.first + n;
      store_points(particles.v, i, load_points<S>(particles.v, i) + motion.at(load_points<S>(particles.x, i)));
    });
  }
};

/// Rigid motion of each body.
template <class R>
struct ComputeRigidMotion {
  const MeasuredBody* bodies;
  RigidMotion<R>* motions;
  KERNEL void operator()(int b) const {
    const Momenta& now = bodies[b].now;
    motions[b] = RigidMotion<R>(now, now.linear, now.spin.L);
  }
};

/// v += k (v_cm + omega x r - v). Pinned particles keep their velocities.
template <class R>
struct DampTowardsRigid {
  using Shared = void;
  Particles<R> particles;
  const ParticleRange* ranges;
  const RigidMotion<R>* motions;  // of each body
  const R* damping;               // of each body: k

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const ParticleRange range = ranges[group.index];
    const RigidMotion<R> motion = motions[range.body];
    const R k = damping[range.body];
    for_each_pack_once<R>(group, range.count, [&]<class S>(int n, S) KERNEL_LAMBDA {
      const int i = range.first + n;
      S w;
      load(particles.w + i, w);
      const Vector3<S> v = load_points<S>(particles.v, i);
      const Vector3<S> change = (motion.at(load_points<S>(particles.x, i)) - v) * S(k);
      store_points(particles.v, i, v + or_zero(w > S(0), change));
    });
  }
};

}  // namespace malha
