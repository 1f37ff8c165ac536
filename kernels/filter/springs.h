// SPDX-License-Identifier: Apache-2.0
// The spring forces of Desbrun's method (Desbrun, Schröder, Barr 1999, section 3), gathered by each particle from its
// own springs: no two lanes write to the same particle, and no colours are needed. A spring is evaluated at both of its
// ends, with exactly opposite forces.
#pragma once
#include "kernels/forces/integrate.h"
#include "kernels/projection/stencil.h"
#include "kernels/simd/rows.h"

namespace malha {

/// Springs by particle, in packs of 16 particles. A pack has as many slots as its particle with the most springs;
/// unused slots connect a particle to itself without stiffness.
template <class R>
struct SpringView {
  const int* begin;           // first slot of each pack, and the number of slots
  const int* other;           // 16 per slot: the particle at the other end, times kIndexScale
  const R *stiffness, *rest;  // 16 per slot: N/m, m
  const R* filtered_mass;     // mass of each particle whose weight is filtered, otherwise 0
  Vector3<R> gravity;         // m/s^2
};

inline constexpr int kSpringPack = 16;

/// Stores x + dt v and x as rows.
template <class R>
struct SpringRows {
  Particles<R> particles;
  R dt;  // the substep h, s
  Vec4<R>*now, *ahead;
  KERNEL void operator()(int i) const {
    const Vector3<R> x = particles.x[i], z = predicted(x, particles.v[i], dt);
    now[i] = {x.x, x.y, x.z, R(0)}, ahead[i] = {z.x, z.y, z.z, R(0)};
  }
};

/// v += dt (a + g); d = dt v, with g only where the weight is not filtered. Pinned particles keep their displacement.
template <class R>
struct FilteredMotion {
  Particles<R> particles;
  Points<R> acceleration;
  const R* filtered_mass;
  R dt;  // the substep h, s
  Vector3<R> gravity;
  KERNEL Vector3<R> velocity(int i) const {
    const bool direct = particles.w[i] > R(0) && !(filtered_mass[i] > R(0));
    const Vector3<R> a = acceleration[i] + gravity * (direct ? R(1) : R(0));
    return particles.v[i] + a * dt;
  }
  KERNEL void operator()(int i) const {
    const Vector3<R> v = velocity(i);
    particles.v.set(i, v);
    particles.p.d.set(i, predicted_displacement(particles.w[i], v, particles.p.d[i], dt));
  }
};

/// Stores the positions to which that motion leads as rows.
template <class R>
struct FilteredRows {
  FilteredMotion<R> motion;
  Vec4<R>* rows;
  KERNEL void operator()(int i) const {
    const Vector3<R> p = predicted(motion.particles.x[i], motion.velocity(i), motion.dt);
    rows[i] = {p.x, p.y, p.z, R(0)};
  }
};

/// l / |d|; 0 where the ends coincide, without direction.
template <class S>
KERNEL S rest_over_length(const Vector3<S>& d, S l) {
  const S zero(0), length = sqrt(dot(d, d));
  return select(length > zero, l / select(length > zero, length, S(1)), zero);
}

/// The weight of particles, where it is filtered.
template <class S, class R>
KERNEL Vector3<S> weight(const SpringView<R>& springs, int first) {
  S m;
  load(springs.filtered_mass + first, m);
  return Vector3<S>{S(springs.gravity.x), S(springs.gravity.y), S(springs.gravity.z)} * m;
}

/// F_i = sum_j -k ((z_i - z_j) - l u), u = (x_i - x_j) / |x_i - x_j|, z = x + dt v: the springs' pull and their
/// artificial viscosity k dt (v_j - v_i); and the weight.
template <class R>
struct ExplicitForces {
  SpringView<R> springs;
  Vec4<R>*now, *ahead;
  Points<R> force;

  /// Positions of an end of a spring: x, and z = x + dt v.
  template <class S>
  struct SpringEnd {
    Vector3<S> x, z;
  };
  template <class S>
  KERNEL SpringEnd<S> read(const int* index) const {
    SpringEnd<S> end;
    S none;
    gather_rows(now, index, end.x, none);
    gather_rows(ahead, index, end.z, none);
    return end;
  }
  template <class S>
  KERNEL static Vector3<S> pull(const SpringEnd<S>& a, const SpringEnd<S>& b, S k, S l) {
    const Vector3<S> d = a.x - b.x;
    return (d * rest_over_length(d, l) - (a.z - b.z)) * k;
  }
  template <class S>
  KERNEL void finish(int first, const Vector3<S>& f) const {
    store_points(force, first, f + weight<S>(springs, first));
  }
};

/// Stores x and the offset of the predicted positions from it as rows.
template <class R>
struct OffsetRows {
  Particles<R> particles;
  Vec4<R>*x, *offset;
  KERNEL void operator()(int i) const {
    const Vector3<R> at = particles.x[i], from = particles.p.offset_from_x(i);
    x[i] = {at.x, at.y, at.z, R(0)}, offset[i] = {from.x, from.y, from.z, R(0)};
  }
};

/// dt^2 F, F_i = sum_j -k (p_i - p_j) of springs of rest length 0 at the predicted positions p, which together are the
/// linear part of stencils. Differences of p are not rounded to the spacing of positions.
template <class R>
struct LinearImpulses {
  SpringView<R> springs;
  Vec4<R>*x, *offset;
  R dt2;              // of the substep, s^2
  Points<R> impulse;  // kg m

  template <class S>
  struct SpringEnd {
    Vector3<S> x, offset;
  };
  template <class S>
  KERNEL SpringEnd<S> read(const int* index) const {
    SpringEnd<S> end;
    S none;
    gather_rows(x, index, end.x, none);
    gather_rows(offset, index, end.offset, none);
    return end;
  }
  template <class S>
  KERNEL static Vector3<S> pull(const SpringEnd<S>& a, const SpringEnd<S>& b, S k, S) {
    return ((b.x - a.x) + (b.offset - a.offset)) * k;
  }
  template <class S>
  KERNEL void finish(int first, const Vector3<S>& f) const {
    store_points(impulse, first, f * S(dt2));
  }
};

/// Residual of backward Euler at p (`rows`): weight - m a + sum_j -k (|d| - l) d / |d|, d = p_i - p_j. It is undefined
/// for pinned particles.
template <class R>
struct MissingForces {
  SpringView<R> springs;
  Vec4<R>* rows;
  Points<R> acceleration;
  const R* mass;
  Points<R> force;

  template <class S>
  KERNEL Vector3<S> read(const int* index) const {
    Vector3<S> p;
    S none;
    gather_rows(rows, index, p, none);
    return p;
  }
  template <class S>
  KERNEL static Vector3<S> pull(const Vector3<S>& a, const Vector3<S>& b, S k, S l) {
    const Vector3<S> d = a - b;
    return d * ((rest_over_length(d, l) - S(1)) * k);
  }
  template <class S>
  KERNEL void finish(int first, const Vector3<S>& f) const {
    S m;
    load(mass + first, m);
    const Vector3<S> a = load_points<S>(acceleration, first);
    store_points(force, first, f + weight<S>(springs, first) - a * m);
  }
};

/// Sums the forces of packs of particles; `has_targets`: those of stencils, too, from rows that ComputeTargets has
/// filled.
template <class R, class Forces, bool has_targets>
struct SumForces {
  using Shared = void;
  Forces forces;
  PullView<R> pulls;
  int packs, size;  // in all, and of a group
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<R, typename Group::Isa>;
    constexpr int lanes = kLanes<R, typename Group::Isa>, parts = kSpringPack / lanes;
    const int begin = group.index * size, end = begin + size < packs ? begin + size : packs;
    group.for_each((end - begin) * parts,
                   [&](int i) KERNEL_LAMBDA { sum<S, lanes>(begin + i / parts, i % parts * lanes); });
  }

 private:
  template <class S, int lanes>
  KERNEL void sum(int pack, int part) const {
    const SpringView<R>& springs = forces.springs;
    const int first = kSpringPack * pack + part;
    int self[lanes];
    for (int i = 0; i < lanes; ++i) self[i] = (first + i) * kIndexScale<R>;
    const auto own = forces.template read<S>(self);
    const S zero(0);
    Vector3<S> f{zero, zero, zero};
    for (int slot = springs.begin[pack]; slot < springs.begin[pack + 1]; ++slot) {
      const int at = kSpringPack * slot + part;
      S k, l;
      load(springs.stiffness + at, k), load(springs.rest + at, l);
      f = f + Forces::pull(own, forces.template read<S>(springs.other + at), k, l);
    }
    if constexpr (has_targets)
      for (int slot = pulls.begin[pack]; slot < pulls.begin[pack + 1]; ++slot) {
        const int at = kSpringPack * slot + part;
        Vector3<S> d;
        S weight, none;
        load(pulls.weight + at, weight);
        gather_rows(pulls.rows, pulls.row + at, d, none);
        f = f + d * weight;
      }
    forces.finish(first, f);
  }
};

}  // namespace malha
