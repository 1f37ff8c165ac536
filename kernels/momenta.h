// The momenta of free bodies, and the rigid motion that gives back what of them the projections took.
#pragma once
#include "kernels/cover.h"
#include "kernels/motion.h"
#include "kernels/pack.h"
#include "kernels/patch.h"

namespace malha {

/// Particles first .. first + count - 1 of one connected body, which begins with the particle `reference`.
struct Stretch {
  int first, count, body, reference;
};

/// Sums over the particles of a stretch, about the place and the velocity of the body's first particle: numbers as
/// small as the body, wherever it is.
struct MomentaSum {
  static constexpr int kMomenta = 10, kAll = 16;  // numbers without and with the inertia
  double place[3], velocity[3];                   // of that particle, m, m/s
  double number[kAll];
  KERNEL double m() const { return number[0]; }           // kg
  KERNEL const double* r() const { return number + 1; }   // m r, kg m
  KERNEL const double* u() const { return number + 4; }   // m u, kg m/s
  KERNEL const double* L() const { return number + 7; }   // r x m u, kg m^2/s
  KERNEL const double* I() const { return number + 10; }  // kg m^2: xx, yy, zz, xy, xz, yz
};

/// Of particles with their state; `projected`: as if the substep ended with the p that they have now. `inertia`: with
/// it. Lanes are added up apart, sixteen of them whatever a pack holds, so that every instruction set gives the same
/// bits.
template <class R, bool projected, bool inertia>
struct MeasureMomenta {
  static constexpr int n = inertia ? MomentaSum::kAll : MomentaSum::kMomenta;
  Particles<R> particles;
  const Stretch* stretches;
  MomentaSum* sums;
  R dt, per_dt;  // s, 1/s, of the substep

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<R, typename Group::Isa>;
    constexpr int lanes = kLanes<R, typename Group::Isa>;
    const Stretch stretch = stretches[group.index];
    const int whole = stretch.count / kSlotPack * kSlotPack;
    R of_lane[n][kSlotPack];
    for (int first = 0; first < kSlotPack; first += lanes) {
      S sum[n];
      for (int k = 0; k < n; ++k) sum[k] = S(R(0));
      for (int i = first; i < whole; i += kSlotPack) add(stretch.reference, stretch.first + i, sum);
      for (int k = 0; k < n; ++k) store(sum[k], &of_lane[k][first]);
    }
    for (int i = whole; i < stretch.count; ++i) {
      R sum[n];
      for (int k = 0; k < n; ++k) sum[k] = of_lane[k][i - whole];
      add(stretch.reference, stretch.first + i, sum);
      for (int k = 0; k < n; ++k) of_lane[k][i - whole] = sum[k];
    }
    MomentaSum& to = sums[group.index];
    const Vector3<R> x = particles.x[stretch.reference], v = particles.v[stretch.reference];
    to.place[0] = x.x, to.place[1] = x.y, to.place[2] = x.z;
    to.velocity[0] = v.x, to.velocity[1] = v.y, to.velocity[2] = v.z;
    for (int k = 0; k < n; ++k) {
      double all = 0;
      for (int i = 0; i < kSlotPack; ++i) all += of_lane[k][i];
      to.number[k] = all;
    }
  }

 private:
  template <class S>
  KERNEL void add(int reference, int i, S (&sum)[n]) const {
    S w;
    load(particles.w + i, w);
    const S m = S(R(1)) / w;
    Vector3<S> x = load_points<S>(particles.x, i), v = load_points<S>(particles.v, i);
    if constexpr (projected) {
      const Vector3<S> p = load_points<S>(particles.p, i);
      v = changed(x, v, p, S(dt), S(per_dt));
      x = p;
    }
    const Vector3<R> x0 = particles.x[reference], v0 = particles.v[reference];
    const Vector3<S> r = x - Vector3<S>{S(x0.x), S(x0.y), S(x0.z)};
    const Vector3<S> u = (v - Vector3<S>{S(v0.x), S(v0.y), S(v0.z)}) * m, L = cross(r, u);
    const Vector3<S> mr = r * m;
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
};

/// v + omega x r, r from a point given by a place and a way from it, which each have few digits.
template <class R>
struct RigidMotion {
  Vector3<R> place, centre;    // m
  Vector3<R> velocity, omega;  // m/s, 1/s
};

/// Adds to each particle the rigid motion of its body.
template <class R>
struct AddRigidMotion {
  using Shared = void;
  Particles<R> particles;
  const Stretch* stretches;
  const RigidMotion<R>* motions;  // of each body

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Stretch stretch = stretches[group.index];
    const RigidMotion<R> motion = motions[stretch.body];
    cover_once<R>(group, stretch.count, [&]<class S>(int i, S) KERNEL_LAMBDA { add<S>(motion, stretch.first + i); });
  }

 private:
  template <class S>
  KERNEL void add(const RigidMotion<R>& motion, int i) const {
    const Vector3<S> r = load_points<S>(particles.x, i) - all<S>(motion.place) - all<S>(motion.centre);
    store_points(particles.v, i,
                 load_points<S>(particles.v, i) + (all<S>(motion.velocity) + cross(all<S>(motion.omega), r)));
  }
  template <class S>
  KERNEL static Vector3<S> all(const Vector3<R>& a) {
    return {S(a.x), S(a.y), S(a.z)};
  }
};

}  // namespace malha
