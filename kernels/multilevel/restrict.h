// SPDX-License-Identifier: Apache-2.0
// Restriction: positions and displacements of a level's particles, which are mass centres of finer particles, computed
// by the patches of the finer level.
#pragma once
#include "kernels/forces/integrate.h"
#include "kernels/multilevel/transfer.h"
#include "kernels/projection/patch.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Destination of a restriction. The terms of `means` index the memory of a patch. If the finer particles of a coarse
/// one lie in several patches, each of them stores a partial sum, and SumPartialRestrictions adds those.
template <class R>
struct RestrictionTarget {
  MeansView<R> means;
  const int* place;
  Points<R> x, d;               // position at the start of the substep relative to the body's origin, and displacement
  Optional<Points<R>> origins;  // of bodies; without: the finer positions are relative to them already
};

/// A substep in which only gravity acts, and the forces that a program sets.
template <class R>
struct FreeFall {
  Points<R> v;         // m/s
  R dt;                // the substep h, s
  Vector3<R> gravity;  // m/s^2
  Points<R> force{};   // N; null: none

  /// The velocity with which particle i of inverse mass w (1/kg) moves: the bits of ApplyForces and Predict.
  template <class T>
  KERNEL Vector3<T> velocity(int i, const T& w) const {
    Vector3<T> now = load_points<T>(v, i);
    if (force.x != nullptr) now = now + load_points<T>(force, i) * (T(dt) * w);
    return apply_gravity(now, w, Vector3<T>{T(gravity.x), T(gravity.y), T(gravity.z)}, T(dt));
  }
};

/// Finer particles: at the end of a substep that begins now, or at their current positions.
template <class R>
struct RestrictedParticles {
  Displaced<R> p;
  const R* w;  // 1/kg
  Optional<FreeFall<R>> fall;

  /// Loads those of a segment into the patch's memory.
  template <class Group, class Local>
  KERNEL void load_segment(const Group& group, const Segment& segment, const Optional<Points<R>>& origins,
                           const Local& local) const {
    const bool falls = fall && segment.movable;
    const Vector3<R> origin = origins ? (*origins)[segment.body] : Vector3<R>{R(0), R(0), R(0)};
    for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      const int at = segment.global + i;
      PatchParticle<T> q;
      load(w + at, q.w);
      q.x = origins ? load_start(p, at, origin, T()) : load_points<T>(p.x, at);
      q.d = falls ? fall->velocity(at, q.w) * T(fall->dt) : load_points<T>(p.d, at);
      local.store_particle(segment.local + i, q);
    });
  }
};

/// Restricts the particles of a patch that no other patch solves after it.
template <class R, class Group, class Local>
KERNEL void restrict_to(const Group& group, const PatchData<R>& data, const Patch& patch,
                        const RestrictedParticles<R>& from, const RestrictionTarget<R>& target, const Local& local) {
  for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
    if (data.segments[s].last_solve) from.load_segment(group, data.segments[s], target.origins, local);
  const auto scatter = [&](const Points<R>& to) KERNEL_LAMBDA {
    return [=](const MeanRun& run, int k, const auto& mean)
               KERNEL_LAMBDA { scatter_points(to, target.place + run.to + k, mean); };
  };
  target.means.each(group, local.positions(), scatter(target.x));
  target.means.each(group, local.displacements(), scatter(target.d));
}

/// The same for one patch of the finer level.
template <class R>
struct Restrict {
  using Shared = void;
  PatchData<R> data;
  RestrictedParticles<R> from;
  RestrictionTarget<R> target;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = data.patches[group.index];
    with_patch_memory<R>(patch, group.memory, [&](const auto& local) KERNEL_LAMBDA {
      restrict_to(group, data, patch, from, target, local);
    });
  }
};

/// x[at[k]] += the partial sums begin[k] .. begin[k + 1] - 1, and d likewise.
template <class R>
struct SumPartialRestrictions {
  const int *at, *begin;
  Points<R> x, d;
  KERNEL void operator()(int k) const { add(x, k), add(d, k); }

 private:
  KERNEL void add(const Points<R>& points, int k) const {
    Vector3<R> sum = points[at[k]];
    for (int part = begin[k]; part < begin[k + 1]; ++part) sum = sum + points[part];
    points.set(at[k], sum);
  }
};

}  // namespace malha
