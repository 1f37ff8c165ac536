// SPDX-License-Identifier: Apache-2.0
// Contact distances of particles. Pairs that are nearer than the thickness at the start, or when pins are released or
// positions are set, are not pushed out to it: that would give them velocity, the more the shorter the substep. They
// keep their distance until they separate by themselves. Every particle has a contact distance (m), an upper bound of
// the minimum distance of its pairs. It is 0 at first, grows to the distance of the nearest pair below the thickness,
// and to the thickness if there is none. Pairs that are compressed later do not change it and are pushed back.
#pragma once
#include "kernels/parallel/compute.h"
#include "kernels/self_collision/narrow_phase.h"
#include "kernels/self_collision/swept_distance.h"

namespace malha {

/// The share of a contact's violation of its minimum distance that is recovered in a substep of h seconds: at most a
/// tenth, and less in substeps below 1.6 ms, so that full recovery takes at least 16 ms: otherwise short substeps would
/// eject compressed bodies.
KERNEL double recovery_share(double h) { return min(0.1, h / 0.016); }

/// Resets the contact distances, except where bodies intersect: pairs keep the distance that they have now.
template <class R>
struct ResetContactDistances {
  Vec4<R>* x0;
  R thickness;
  KERNEL void operator()(int i) const {
    if (!(x0[i].w > thickness)) x0[i].w = R(0);
  }
};

/// Marks particles where bodies intersect by a contact distance above the thickness: their pairs are left out. Once the
/// bodies have separated, the contact distance is reset.
template <class R>
struct MarkCrossingBodies {
  Vec4<R>* x0;
  R thickness;
  const CrossingBodies* crosses;  // null: no bodies intersect any more
  KERNEL void operator()(int i) const {
    if (crosses != nullptr && crosses[i] != 0)
      x0[i].w = R(2) * thickness;
    else if (x0[i].w > thickness)
      x0[i].w = R(0);
  }
};

/// Finds the smallest distance of each particle's pairs that are below their minimum distance. Where mapped, a particle
/// that is thicker than its pair counts the pair as farther by as much, because other pairs of it are. Groups: patches
/// of one colour.
template <class R, bool mapped = false>
struct FindNearestPairs {
  using Shared = void;
  static constexpr int kMostThreads = 32;  // half of them have a pair of a block
  Trajectories<R> motions;
  Pairs<R> pairs;
  R* nearest;
  R thickness = R(0);         // of self-collision, m, and
  const R* factor = nullptr;  // the factor of each particle, where mapped
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for_each_pair(group, pairs,
                  [&](const ContactBlock<R>& block, int k, int first) KERNEL_LAMBDA { find(block, k, first); });
  }

 private:
  KERNEL void find(const ContactBlock<R>& block, int k, int first) const {
    if (!(block.min_distance[k] > -R(INFINITY))) return;
    const R distance = ContactFrameDouble<R>(PairRows<R>(motions.x0, block, k).of, first).distance;
    if (!(distance > R(0) && distance < block.min_distance[k])) return;
    R thinnest = R(1);
    if constexpr (mapped) {
      for (int j = 0; j < 4; ++j) thinnest = min(thinnest, factor[block.i[j][k] / kIndexScale<R>]);
      if (!(distance < thickness * thinnest)) return;
    }
    for (int j = 0; j < 4; ++j) {
      const int i = block.i[j][k] / kIndexScale<R>;
      R seen = distance;
      if constexpr (mapped) seen = distance * (factor[i] / thinnest);
      nearest[i] = min(nearest[i], seen);
    }
  }
};

/// Grows the contact distances. Returns how many are still below the thickness, which where mapped is that of each
/// particle.
template <class R, bool mapped = false>
struct GrowContactDistances {
  Vec4<R>* x0;
  R thickness;
  const R* nearest;
  const R* factor = nullptr;  // of the thickness, at most 1, where mapped
  KERNEL Sum operator()(int i) const {
    const R most = mapped ? thickness * factor[i] : thickness;
    x0[i].w = max(x0[i].w, min(nearest[i], most));
    return {x0[i].w < most ? 1.0 : 0.0};
  }
};

}  // namespace malha
