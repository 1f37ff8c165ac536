// SPDX-License-Identifier: Apache-2.0
// What is nearer than the thickness at the start, or where pins let go or particles are put, is not pushed out to it:
// that would give it speed, and the more the shorter the substep. It stays as near as it is until it opens by itself.
// Every particle has a contact distance (m), which bounds that of its pairs: at first 0, it grows to the distance of
// the nearest of them that lacks some of the thickness, and to the thickness where there is none. What is pressed
// together later does not change it, and is pushed back.
#pragma once
#include "kernels/self_collision/narrow_phase.h"
#include "kernels/self_collision/swept_distance.h"

namespace malha {

/// The share of what a contact lacks that it makes up for in a substep of h seconds: a tenth, but all of it in no less
/// than 16 ms, since short substeps would shoot apart what is pressed together.
KERNEL double recovery_share(double h) { return min(0.1, h / 0.016); }

/// Everything stays as near as it is now, but where bodies cross.
template <class R>
struct ResetContactDistances {
  Vec4<R>* x0;
  R thickness;
  KERNEL void operator()(int i) const {
    if (!(x0[i].w > thickness)) x0[i].w = R(0);
  }
};

/// Where bodies cross, pairs take no part: a contact distance above the thickness marks their particles. Once they have
/// parted they are as near as they are then.
template <class R>
struct MarkCrossingBodies {
  Vec4<R>* x0;
  R thickness;
  const CrossingBodies* crosses;  // null: nothing does any more
  KERNEL void operator()(int i) const {
    if (crosses != nullptr && crosses[i] != 0)
      x0[i].w = R(2) * thickness;
    else if (x0[i].w > thickness)
      x0[i].w = R(0);
  }
};

/// How near the nearest of each particle's pairs is, of those that lack some of what is wanted. Groups: patches of one
/// phase.
template <class R>
struct FindNearestPairs {
  using Shared = void;
  static constexpr int kMostThreads = 32;  // half of them have a pair of a block
  Trajectories<R> motions;
  Pairs<R> pairs;
  R* nearest;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for_each_pair(group, pairs,
                  [&](const ContactBlock<R>& block, int k, int first) KERNEL_LAMBDA { find(block, k, first); });
  }

 private:
  KERNEL void find(const ContactBlock<R>& block, int k, int first) const {
    if (!(block.min_distance[k] > -R(INFINITY))) return;
    const R distance = ContactFrameDouble<R>(motions.x0, block, k, first).distance;
    if (!(distance > R(0) && distance < block.min_distance[k])) return;
    for (int j = 0; j < 4; ++j) {
      R& own = nearest[block.i[j][k] / kIndexScale<R>];
      own = min(own, distance);
    }
  }
};

/// Returns how many have less than the thickness still.
template <class R>
struct GrowContactDistances {
  Vec4<R>* x0;
  R thickness;
  const R* nearest;
  KERNEL Sum operator()(int i) const {
    x0[i].w = max(x0[i].w, min(nearest[i], thickness));
    return {x0[i].w < thickness ? 1.0 : 0.0};
  }
};

}  // namespace malha
