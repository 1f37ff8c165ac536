// SPDX-License-Identifier: Apache-2.0
// Solves one patch of a level: loads its restricted particles, adds the correction of the next coarser level, projects,
// and stores the correction for the next finer level.
#pragma once
#include "kernels/multilevel/coarse_constraint.h"
#include "kernels/multilevel/transfer.h"
#include "kernels/simd/particles.h"

namespace malha {

template <class R>
struct SolveCoarsePatch {
  using Shared = void;
  const Patch* patches;
  const Segment* segments;
  const Batch* batches;
  const SetView<R>* sets;
  Points<R> x;             // position at the start of the substep, relative to the body's origin, m
  Points<R> restricted_d;  // restricted displacement, m
  Points<R> d;             // displacement of particles that are solved again, between the solves, m
  const R* w;              // 1/kg, 0 where pinned
  Points<R> delta;  // result d - restricted_d, by rank: a structure of arrays or, if delta_rows is not null, rows
  ScatteredPoints<R> delta_rows;
  const int* rank;                   // of each particle
  ProlongationView<R> prolongation;  // from the next coarser level, if there is one
  bool prefetches;                   // as in SolvePatch
  bool forward, backward;            // as in SolvePatch: both halve the error of one for a tenth of a step's time

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = patches[group.index];
    R* memory = static_cast<R*>(group.memory);
    if (patch.columns)
      solve(group, patch, SoaView<R>::over(memory, patch.slots));
    else
      solve(group, patch, AosView<R>::over(memory, patch.slots));
  }

 private:
  template <class Group, class Local>
  KERNEL void solve(const Group& group, const Patch& patch, const Local& local) const {
    const int begin = patch.segment, end = patch.segment + patch.segments;
    for (int s = begin; s < end; ++s) load_segment(group, segments[s], local);
    project(group, patch, local, Sweep::StoreDistances);
    for (int s = begin; s < end; ++s)
      if (!(forward && segments[s].first_solve)) load_displacements(group, segments[s], local);
    if (forward && prolongation.means.begin) prolongate(group, prolongation, local);
    if (forward) project(group, patch, local, Sweep::Forward);
    if (backward) project(group, patch, local, Sweep::Backward);
    for (int s = begin; s < end; ++s)
      if (segments[s].movable) store_correction(group, segments[s], local);
  }
  enum class Sweep { StoreDistances, Forward, Backward };

  KERNEL void prefetch_patch(const Patch& patch, int part, int parts) const {
    for (int s = patch.segments * part / parts; s < patch.segments * (part + 1) / parts; ++s) {
      const Segment& segment = segments[patch.segment + s];
      for (int i = segment.global; i < segment.global + segment.count; i += 64 / int(sizeof(R))) {
        prefetch(x.x + i), prefetch(x.y + i), prefetch(x.z + i), prefetch(w + i), prefetch(rank + i);
        prefetch(restricted_d.x + i), prefetch(restricted_d.y + i), prefetch(restricted_d.z + i);
      }
    }
  }

  template <class Group, class Local>
  KERNEL void load_segment(const Group& group, const Segment& segment, const Local& local) const {
    for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      const int at = segment.global + i;
      PatchParticle<T> q{load_points<T>(x, at), load_points<T>(restricted_d, at), T()};
      load(w + at, q.w);
      local.store_particle(segment.local + i, q);
    });
  }
  template <class Group, class Local>
  KERNEL void load_displacements(const Group& group, const Segment& segment, const Local& local) const {
    if (!segment.movable) return;
    for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      local.store_displacement(segment.local + i, load_points<T>(d, segment.global + i));
    });
  }

  template <class Group, class Local>
  KERNEL void store_correction(const Group& group, const Segment& segment, const Local& local) const {
    const bool last = backward && segment.last_solve;
    for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      const Vector3<T> displacement = local.template load_displacement<T>(segment.local + i);
      const int at = segment.global + i;
      if (last && delta_rows.of)
        scatter_points(delta_rows, rank + at, displacement - load_points<T>(restricted_d, at));
      else if (last)
        scatter_points(delta, rank + at, displacement - load_points<T>(restricted_d, at));
      else
        store_points(d, at, displacement);
    });
  }

  /// `least`: the smallest distance of each slot of the patch's constraints, in the order of its batches.
  template <class Group, class Local>
  struct ProjectBatches {
    Group group;
    Local local;
    const SolveCoarsePatch* solve;
    R* least;
    Sweep sweep;
    const Patch* patch;
    KERNEL void operator()(int b) const {
      const bool first_iteration = sweep == Sweep::StoreDistances;
      if (sweep == Sweep::Backward) b = 2 * patch->batch + patch->batches - 1 - b;
      if (first_iteration && solve->prefetches && group.next >= 0)
        solve->prefetch_patch(solve->patches[group.next], b - patch->batch, patch->batches);
      Batch batch = solve->batches[b];
      SetView<R> set = solve->sets[batch.set];
      set.lambda = least;
      batch.slot = batch.first;
      malha::project<Coarse, Update::Stiff>(group, local, set, batch, first_iteration);
    }
  };

  template <class Group, class Local>
  KERNEL void project(const Group& group, const Patch& patch, const Local& local, Sweep sweep) const {
    R* least = static_cast<R*>(group.memory) + size_t(kNumbersPerParticle) * patch.slots;
    group.call_outlined(patch.batch, patch.batch + patch.batches,
                        ProjectBatches<Group, Local>{group, local, this, least, sweep, &patch});
  }
};

}  // namespace malha
