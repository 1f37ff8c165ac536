// One visit to a patch of a level: its particles arrive, follow the next coarser level, are projected, and leave what
// was changed of them for the next finer one.
#pragma once
#include "kernels/coarse.h"
#include "kernels/means.h"

namespace malha {

/// Of a visit: two halve the error of one for a tenth of a step's time.
inline constexpr int kCoarseSweeps = 2;

template <class R>
struct CoarseVisit {
  using Shared = void;
  const Patch* patches;
  const Segment* segments;
  const Batch* batches;
  const SetView<R>* sets;
  Points<R> b;      // places on arrival, m
  Points<R> p;      // of particles that more than one patch visits, between the visits
  const R* w;       // 1/kg, 0 where pinned
  Points<R> delta;  // p - b, by rank: as columns, or, where there are any, as rows
  ScatteredPoints<R> delta_rows;
  const int* rank;  // of each particle
  MeansOf<R> down;  // of the next coarser level, if there is one
  bool prefetches;  // as in Visit

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const Patch& patch = patches[group.index];
    R* memory = static_cast<R*>(group.memory);
    if (patch.columns)
      visit(group, patch, Columns<R>::over(memory, patch.slots));
    else
      visit(group, patch, Rows<R>::over(memory, patch.slots));
  }

 private:
  template <class Group, class Local>
  KERNEL void visit(const Group& group, const Patch& patch, const Local& local) const {
    const int begin = patch.segment, end = patch.segment + patch.segments;
    for (int s = begin; s < end; ++s) bring(group, segments[s], b, local);
    project(group, patch, local, true);
    for (int s = begin; s < end; ++s)
      if (!segments[s].first) bring(group, segments[s], p, local);
    if (down.means.begin) add_means(group, down, local);
    for (int sweep = 0; sweep < kCoarseSweeps; ++sweep) project(group, patch, local, false);
    for (int s = begin; s < end; ++s)
      if (segments[s].movable) leave(group, segments[s], local);
  }

  KERNEL void ask_for(const Patch& patch, int part, int parts) const {
    for (int s = patch.segments * part / parts; s < patch.segments * (part + 1) / parts; ++s) {
      const Segment& segment = segments[patch.segment + s];
      for (int i = segment.global; i < segment.global + segment.count; i += 64 / int(sizeof(R)))
        prefetch(b.x + i), prefetch(b.y + i), prefetch(b.z + i), prefetch(w + i), prefetch(rank + i);
    }
  }

  template <class Group, class Local>
  KERNEL void bring(const Group& group, const Segment& segment, const Points<R>& from, const Local& local) const {
    cover<R>(group, segment.count, [&]<class T>(int i, T of) KERNEL_LAMBDA {
      load(w + segment.global + i, of);
      local.fill(segment.local + i, load_points<T>(from, segment.global + i), of);
    });
  }

  template <class Group, class Local>
  KERNEL void leave(const Group& group, const Segment& segment, const Local& local) const {
    cover<R>(group, segment.count, [&]<class T>(int i, T) KERNEL_LAMBDA {
      Vector3<T> q;
      T of;
      local.read(segment.local + i, q, of);
      const int at = segment.global + i;
      if (segment.last && delta_rows.of)
        scatter_points(delta_rows, rank + at, q - load_points<T>(b, at));
      else if (segment.last)
        scatter_points(delta, rank + at, q - load_points<T>(b, at));
      else
        store_points(p, at, q);
    });
  }

  /// `least`: a place for every slot of the patch's constraints, in the order of its batches.
  template <class Group, class Local>
  struct ProjectBatches {
    Group group;
    Local local;
    const CoarseVisit* visit;
    R* least;
    bool fresh;
    const Patch* patch;
    KERNEL void operator()(int b) const {
      if (fresh && visit->prefetches && group.next >= 0)
        visit->ask_for(visit->patches[group.next], b - patch->batch, patch->batches);
      Batch batch = visit->batches[b];
      SetView<R> set = visit->sets[batch.set];
      set.lambda = least;
      batch.slot = batch.first;
      malha::project<Coarse, Update::Stiff>(group, local, set, batch, fresh);
    }
  };

  template <class Group, class Local>
  KERNEL void project(const Group& group, const Patch& patch, const Local& local, bool fresh) const {
    R* least = static_cast<R*>(group.memory) + size_t(4) * patch.slots;
    group.apart(patch.batch, patch.batch + patch.batches,
                ProjectBatches<Group, Local>{group, local, this, least, fresh, &patch});
  }
};

}  // namespace malha
