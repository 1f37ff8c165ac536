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
  PatchData<R> data;
  Points<R> x;                                 // position at the start of the substep, relative to the body's origin, m
  Points<R> restricted_d;                      // restricted displacement, m
  const R* w;                                  // 1/kg, 0 where pinned
  Points<R> d;                                 // displacement of particles that are solved again, between the solves, m
  Corrections<R> delta;                        // result: displacement less restricted_d, m
  const int* rank;                             // of each particle
  Optional<ProlongationView<R>> prolongation;  // from the next coarser level, if there is one
  Sweeps sweeps;                               // both halve the error of one for a tenth of a step's time

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = data.patches[group.index];
    with_patch_memory<R>(patch, group.memory, [&](const auto& local) KERNEL_LAMBDA { solve(group, patch, local); });
  }

 private:
  template <class Group, class Local>
  KERNEL void solve(const Group& group, const Patch& patch, const Local& local) const {
    const int begin = patch.segment, end = patch.segment + patch.segments;
    for (int s = begin; s < end; ++s) load_segment(group, data.segments[s], local);
    project(group, patch, local, Sweep::StoreDistances);
    for (int s = begin; s < end; ++s)
      if (!(goes_forward(sweeps) && data.segments[s].first_solve)) load_displacements(group, data.segments[s], local);
    if (goes_forward(sweeps) && prolongation) prolongate(group, *prolongation, local);
    if (goes_forward(sweeps)) project(group, patch, local, Sweep::Forward);
    if (goes_backward(sweeps)) project(group, patch, local, Sweep::Backward);
    for (int s = begin; s < end; ++s)
      if (data.segments[s].movable) store_correction(group, data.segments[s], local);
  }
  enum class Sweep { StoreDistances, Forward, Backward };

  KERNEL void prefetch_patch(const Patch& patch, int part, int parts) const {
    for (int s = patch.segments * part / parts; s < patch.segments * (part + 1) / parts; ++s) {
      const Segment& segment = data.segments[patch.segment + s];
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
    const bool last = goes_backward(sweeps) && segment.last_solve;
    delta.with_layout([&](const auto& to) KERNEL_LAMBDA {
      for_each_pack<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
        const Vector3<T> displacement = local.template load_displacement<T>(segment.local + i);
        const int at = segment.global + i;
        if (last)
          scatter_points(to, rank + at, displacement - load_points<T>(restricted_d, at));
        else
          store_points(d, at, displacement);
      });
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
      const PatchData<R>& data = solve->data;
      if (first_iteration && data.prefetches && group.next >= 0)
        solve->prefetch_patch(data.patches[group.next], b - patch->batch, patch->batches);
      Batch batch = data.batches[b];
      SetView<R> set = data.sets[batch.set];
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
