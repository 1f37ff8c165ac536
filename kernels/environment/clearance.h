// SPDX-License-Identifier: Apache-2.0
// Clearance of particles from environment meshes: lower bounds of their distances, and their speeds. Both together tell
// whether the particles can move for a whole step without contact tests. Particles that turn out to be faster are
// clamped afterwards.
#pragma once
#include "kernels/environment/broad_phase.h"
#include "kernels/simd/for_each_pack.h"

namespace malha {

/// Clearance of a group of particles.
struct Clearance {
  float distance;  // m, lower bound of the distance to any mesh, less the range of its contacts
  float speed2;    // largest squared speed, m^2/s^2
};

/// Least clearance and largest speed of all groups, as a reduction.
struct MinClearance {
  float distance = INFINITY, speed2 = 0;
  KERNEL MinClearance& operator+=(const MinClearance& other) {
    distance = other.distance < distance ? other.distance : distance;
    speed2 = speed2 < other.speed2 ? other.speed2 : speed2;
    return *this;
  }
  /// Largest speed (m/s) during the next `substeps` of h seconds at which no particle comes into the range of a
  /// contact; 0: one may. `g`: gravity, m/s^2.
  KERNEL double max_contact_free_speed(double h, int substeps, double g) const {
    const double speed = (distance - g * h * h) / ((substeps + 1) * h);
    return sqrt(speed2) + g * h * substeps < speed ? speed : 0;
  }
};
struct ReduceClearance {
  const Clearance* clearance;
  KERNEL MinClearance operator()(int g) const { return {clearance[g].distance, clearance[g].speed2}; }
};

/// Measures the clearance from one mesh at rest, and combines it with that from the meshes before. Pinned particles do
/// not count.
template <class R>
struct MeasureClearance {
  Points<R> x, v;
  const R* w;
  int count;
  ProximityCacheView<R> cache;
  float contact_range;  // m
  float rounding;       // relative error of positions
  bool first;           // whether this is the first mesh
  Clearance* clearance;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    constexpr int lanes = kLanes<float, Isa>;
    Clearance& own = clearance[group.index];
    PackMax<float, Isa> negative_distance(first ? -INFINITY : -own.distance), speed2(first ? 0 : own.speed2);
    const auto add_all = [&](const auto& entries) KERNEL_LAMBDA {
      const int begin = group.index * kGroupSize, n = count - begin < kGroupSize ? count - begin : kGroupSize;
      int k = 0;
      for (; k + lanes <= n; k += lanes) add<Lane<float, Isa>>(entries, begin, k, negative_distance, speed2);
      for (; k < n; ++k) add<float>(entries, begin, k, negative_distance, speed2);
    };
    const GroupEntries* const entries = cache.entries_of(group.index);
    entries ? add_all(ParticleEntries{entries}) : add_all(BoxEntry(cache.boxes[group.index]));
    own = {-negative_distance.value(), speed2.value()};
  }

 private:
  template <class S, class Entries, class Most>
  KERNEL void add(const Entries& entries, int begin, int k, Most& negative_distance, Most& speed2) const {
    const int i = begin + k;
    const Vector3<S> position = load_floats<S>(x, i), velocity = load_floats<S>(v, i);
    const CacheEntryLanes<S> entry = entries.from(k, position);
    const Vector3<S> moved = position - entry.at;
    S inverse_mass;
    load_float(w + i, inverse_mass);
    const S slack = (l1_norm(position) + abs(entry.distance)) * S(rounding);
    const S distance = entry.distance - sqrt(dot(moved, moved)) - S(contact_range) - slack;
    const auto moves = inverse_mass > S(0.0f);
    const S negative = select(distance < S(INFINITY), S(0.0f) - distance, S(INFINITY));  // NaN: no clearance
    negative_distance.add(select(moves, negative, S(-INFINITY)));
    speed2.add(select(moves, dot(velocity, velocity), S(0.0f)));
  }
};

/// Reconstructs the positions a substep ago (to the rounding of x), and the displacements since.
template <class R>
struct ReconstructPrevious {
  Particles<R> particles;
  Points<R> before;
  R dt;  // the substep h, s
  KERNEL void operator()(int i) const {
    const Vector3<R> displacement = particles.v[i] * dt;
    particles.p.d.set(i, displacement);
    before.set(i, particles.x[i] - displacement);
  }
};

/// Commits the positions of particles that were clamped after their substep, and v accordingly: those whose
/// displacement is no longer the one that ReconstructPrevious set.
template <class R>
struct CommitClamped {
  Particles<R> particles;
  R dt, per_dt;  // the substep h (s), and 1 / h
  KERNEL void operator()(int i) const {
    const Vector3<R> shift = particles.p.d[i] - particles.v[i] * dt;
    particles.p.d.set(i, shift);
    if (shift.x == R(0) && shift.y == R(0) && shift.z == R(0)) return;
    particles.v.set(i, particles.v[i] + shift * per_dt);
    particles.p.advance_x(i), particles.p.clear_displacement(i);
  }
};

}  // namespace malha
