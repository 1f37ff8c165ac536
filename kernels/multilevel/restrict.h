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
  Points<R> x, d;     // position at the start of the substep relative to the body's origin, and displacement
  Points<R> origins;  // of bodies; null: the finer positions are relative to them already
};

/// Restricts the particles in a patch's memory.
template <class R, class Group, class Local>
KERNEL void restrict_to(const Group& group, const RestrictionTarget<R>& target, const Local& local) {
  const auto scatter = [&](const Points<R>& to) KERNEL_LAMBDA {
    return [=](const MeanRun& run, int k, const auto& mean)
               KERNEL_LAMBDA { scatter_points(to, target.place + run.to + k, mean); };
  };
  target.means.each(group, local, scatter(target.x));
  target.means.each(group, local.displacements(), scatter(target.d));
}

/// Particles after dt if only gravity acts on them; with null v, at their current positions.
template <class R>
struct PredictedParticles {
  Displaced<R> p;
  Points<R> v;         // m/s
  const R* w;          // 1/kg
  Points<R> origins;   // as in RestrictionTarget
  R dt;                // the substep h, s
  Vector3<R> gravity;  // m/s^2

  /// Loads those of a segment into the patch's memory.
  template <class Group, class Local>
  KERNEL void load_segment(const Group& group, const Segment& segment, const Local& local) const {
    const bool predicts = v.x && segment.movable;
    const Vector3<R> origin = origins.x ? origins[segment.body] : Vector3<R>{R(0), R(0), R(0)};
    for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      const int at = segment.global + i;
      PatchParticle<T> q;
      load(w + at, q.w);
      q.x = origins.x ? load_start(p, at, origin, T()) : load_points<T>(p.x, at);
      if (predicts) {
        const Vector3<T> g{T(gravity.x), T(gravity.y), T(gravity.z)};
        q.d = apply_gravity(load_points<T>(v, at), q.w, g, T(dt)) * T(dt);
      } else {
        q.d = load_points<T>(p.d, at);
      }
      local.store_particle(segment.local + i, q);
    });
  }
};

/// Restricts the particles of one patch of the finer level.
template <class R>
struct Restrict {
  using Shared = void;
  const Patch* patches;
  const Segment* segments;
  PredictedParticles<R> from;
  RestrictionTarget<R> target;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = patches[group.index];
    R* memory = static_cast<R*>(group.memory);
    if (patch.columns)
      restrict_patch(group, patch, SoaView<R>::over(memory, patch.slots));
    else
      restrict_patch(group, patch, AosView<R>::over(memory, patch.slots));
  }

 private:
  template <class Group, class Local>
  KERNEL void restrict_patch(const Group& group, const Patch& patch, const Local& local) const {
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
      if (segments[s].last_solve) from.load_segment(group, segments[s], local);
    restrict_to(group, target, local);
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
