// The spring forces of Desbrun's method (Desbrun, Schröder, Barr 1999, section 3), gathered by each particle from its
// own springs: no two lanes write to the same place, and no colours are needed. A spring is evaluated at both of its
// ends, to exactly opposite forces.
#pragma once
#include "kernels/pack.h"
#include "kernels/particles.h"

namespace malha {

/// Particles in packs of 16. A pack has as many slots as its particle with the most springs; those that a particle does
/// not need lead to itself with no stiffness.
template <class R>
struct SpringView {
  const int* begin;           // of each pack's slots, and one more
  const int* other;           // 16 a slot: the particle at the other end, times kIndexScale
  const R *stiffness, *rest;  // 16 a slot: N/m, m
  const R* load;              // of each particle: its mass where the filter sees its weight, otherwise 0
  Vector3<R> gravity;         // m/s^2
};

inline constexpr int kSpringPack = 16;

/// x + dt v, and the positions, as rows.
template <class R>
struct SpringRows {
  Particles<R> particles;
  R dt;
  Vec4<R>*now, *ahead;
  KERNEL void operator()(int i) const {
    const Vector3<R> x = particles.x[i], z = x + particles.v[i] * dt;
    now[i] = {x.x, x.y, x.z, R(0)}, ahead[i] = {z.x, z.y, z.z, R(0)};
  }
};

/// Where the filter has brought the particles, as rows: x + dt (v + dt (a + g)), the weight only where the filter does
/// not see it. Pinned particles stay.
template <class R>
struct FilteredRows {
  Particles<R> particles;
  Points<R> acceleration;
  const R* load;
  R dt;
  Vector3<R> gravity;
  Vec4<R>* rows;
  KERNEL void operator()(int i) const {
    const bool direct = particles.w[i] > R(0) && !(load[i] > R(0));
    const Vector3<R> a = acceleration[i] + gravity * (direct ? R(1) : R(0));
    const Vector3<R> p = particles.x[i] + (particles.v[i] + a * dt) * dt;
    rows[i] = {p.x, p.y, p.z, R(0)};
  }
};

/// v += dt (a + g); p = x + dt v. As FilteredRows.
template <class R>
struct FilteredMotion {
  Particles<R> particles;
  Points<R> acceleration;
  const R* load;
  R dt;
  Vector3<R> gravity;
  KERNEL void operator()(int i) const {
    const bool direct = particles.w[i] > R(0) && !(load[i] > R(0));
    const Vector3<R> a = acceleration[i] + gravity * (direct ? R(1) : R(0));
    const Vector3<R> v = particles.v[i] + a * dt;
    particles.v.set(i, v);
    particles.p.set(i, particles.x[i] + v * dt);
  }
};

/// F_i = sum_j -k ((z_i - z_j) - l u), u = (x_i - x_j) / |x_i - x_j|, z = x + dt v: the springs' pull and their
/// artificial viscosity k dt (v_j - v_i); and the weight.
template <class R>
struct ExplicitForces {
  SpringView<R> springs;
  Vec4<R>*now, *ahead;
  Points<R> force;
  template <class S>
  KERNEL void operator()(int first, const Vector3<S>& f) const {
    S load_;
    load(springs.load + first, load_);
    const Vector3<S> g{S(springs.gravity.x), S(springs.gravity.y), S(springs.gravity.z)};
    put(first, f + g * load_);
  }
  template <class S>
  struct Own {
    Vector3<S> x, z;
  };
  template <class S, class Index>
  KERNEL Own<S> read(const Index* index) const {
    Own<S> own;
    S none;
    gather_rows(now, index, own.x, none);
    gather_rows(ahead, index, own.z, none);
    return own;
  }
  template <class S>
  KERNEL static Vector3<S> pull(const Own<S>& a, const Own<S>& b, S k, S l) {
    const Vector3<S> d = a.x - b.x;
    const S zero(R(0)), one(R(1)), length = root(dot(d, d));
    const S stretch = select(length > zero, l / select(length > zero, length, one), zero);  // coincident: no direction
    return (d * stretch - (a.z - b.z)) * k;
  }

 private:
  template <class S>
  KERNEL void put(int first, const Vector3<S>& f) const {
    store(f.x, force.x + first), store(f.y, force.y + first), store(f.z, force.z + first);
  }
};

/// What is missing from backward Euler at p (`rows`): weight - m a + sum_j -k (|d| - l) d / |d|, d = p_i - p_j. Of
/// pinned particles anything.
template <class R>
struct MissingForces {
  SpringView<R> springs;
  Vec4<R>* rows;
  Points<R> acceleration;
  const R* mass;
  Points<R> force;
  template <class S>
  using Own = Vector3<S>;
  template <class S, class Index>
  KERNEL Vector3<S> read(const Index* index) const {
    Vector3<S> p;
    S none;
    gather_rows(rows, index, p, none);
    return p;
  }
  template <class S>
  KERNEL static Vector3<S> pull(const Vector3<S>& a, const Vector3<S>& b, S k, S l) {
    const Vector3<S> d = a - b;
    const S zero(R(0)), one(R(1)), length = root(dot(d, d));
    const S stretch = select(length > zero, l / select(length > zero, length, one), zero);
    return d * ((stretch - one) * k);
  }
  template <class S>
  KERNEL void operator()(int first, const Vector3<S>& f) const {
    S weighs, m;
    Vector3<S> a;
    load(springs.load + first, weighs), load(mass + first, m);
    load(acceleration.x + first, a.x), load(acceleration.y + first, a.y), load(acceleration.z + first, a.z);
    const Vector3<S> g{S(springs.gravity.x), S(springs.gravity.y), S(springs.gravity.z)};
    const Vector3<S> missing = f + g * weighs - a * m;
    store(missing.x, force.x + first), store(missing.y, force.y + first), store(missing.z, force.z + first);
  }
};

/// Sums the forces of packs of particles.
template <class R, class Forces>
struct SumForces {
  Forces forces;
  int packs, size;  // in all, and of a group
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<R, typename Group::Isa>;
    constexpr int lanes = kLanes<R, typename Group::Isa>;
    const int begin = group.index * size, end = begin + size < packs ? begin + size : packs;
    for (int pack = begin; pack < end; ++pack)
      for (int part = 0; part < kSpringPack; part += lanes) sum<S, lanes>(pack, part);
  }

 private:
  template <class S, int lanes>
  KERNEL void sum(int pack, int part) const {
    const SpringView<R>& springs = forces.springs;
    const int first = kSpringPack * pack + part;
    int self[lanes];
    for (int i = 0; i < lanes; ++i) self[i] = (first + i) * kIndexScale<R>;
    const auto own = forces.template read<S>(self);
    const S zero(R(0));
    Vector3<S> f{zero, zero, zero};
    for (int slot = springs.begin[pack]; slot < springs.begin[pack + 1]; ++slot) {
      const int at = kSpringPack * slot + part;
      S k, l;
      load(springs.stiffness + at, k), load(springs.rest + at, l);
      f = f + Forces::pull(own, forces.template read<S>(springs.other + at), k, l);
    }
    forces(first, f);
  }
};

}  // namespace malha
