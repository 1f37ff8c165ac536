// SPDX-License-Identifier: Apache-2.0
// Final guard of a substep: displacements are truncated so that no pair of primitives intersects. At x0 none does.
// Every pair that could come near was found, because no particle leaves the box that it was searched with; and a pair
// stays apart if a plane of normal n is between its sides at the end as at the start, because between them every
// particle moves along a line: in between a plane between the planes does. Where a pair is about to break this, its
// particles are held back: each to its own half of the gap. Those of other pairs that this leads to are held back next,
// until all pairs are apart. In the spirit of Chen et al., "Offset Geometric Contact" (2025), but with planes, not
// balls, so that layers slide freely, and only where something would cross, so that what moves as a whole is not slowed
// down.
#pragma once
#include "kernels/self_collision/narrow_phase.h"

namespace malha {

/// What becomes of a particle while others are held. Driven: by pins, out of their way; Carried: with them.
enum class MotionState : unsigned char { Free, Pushed, Truncating, Truncated, Kinematic };

/// Pairs of a patch, or of all, that are about to cross: those that holding back can still help, and those of particles
/// that are fixed.
struct ViolationCount {
  int free = 0, fixed = 0;
  KERNEL ViolationCount& operator+=(const ViolationCount& o) {
    free += o.free, fixed += o.fixed;
    return *this;
  }
};

/// Marks the pairs of a patch that are about to cross, and counts them. A pair that was not near becomes so, if `adds`.
template <class R>
struct FindViolations {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  const R* room;
  bool adds;
  const MotionState* held;  // none: nothing is held yet
  ViolationCount* left;     // of each patch

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    const PairPatch patch = pairs.patches[group.index];
    const R most = can_close(group, patch);
    if (room[group.index] > most) {
      left[group.index] = {};
      return;
    }
    const bool reads_most = most > R(10) * rules.ahead;  // blocks: they move by about the thickness
    left[group.index] = group.reduce(
        patch.all(), ViolationCount{},
        [&](int k) KERNEL_LAMBDA {
          if (reads_most) prefetch_planes(pairs.blocks + patch.begin + k + kBlocksAhead);
          return look<Isa>(patch.begin + k, patch.section_of(k), most);
        },
        [](ViolationCount& count, const ViolationCount& of_block) KERNEL_LAMBDA { count += of_block; });
  }

 private:
  /// At most, any gap of the patch, m: its particles have moved no more than this against each other.
  template <class Group>
  KERNEL R can_close(const Group& group, const PairPatch& patch) const {
    const int* const of = pairs.touched + patch.touched;
    const Vector3<R> first = motions.moved[of[0]].xyz();
    const R most2 = group.reduce(
        patch.touches, R(0),
        [&](int k) KERNEL_LAMBDA {
          const Vector3<R> beside = motions.moved[of[k]].xyz() - first;
          return dot(beside, beside);
        },
        [](R& most, R one) KERNEL_LAMBDA { most = max(one, most); });
    return R(2.001) * sqrt(most2);
  }

  template <class Isa>
  KERNEL ViolationCount look(int b, int section, R most) const {
    ContactBlock<R>& block = pairs.blocks[b];
    const unsigned found =
        section == 0 ? look<Isa, PairKind::Face>(block, most) : look<Isa, PairKind::Edges>(block, most);
    pairs.bits[b].crossing = static_cast<unsigned short>(found);
    ViolationCount count;
    for (unsigned bits = found; bits != 0; bits &= bits - 1) {
      const int k = lowest_bit(bits);
      const ViolationCount one = left_of(block, k);
      count += one;
      if (one.free > 0 && adds && !(pairs.bits[b].near >> k & 1)) add(block, k, section, pairs.bits[b]);
    }
    return count;
  }

  template <class Isa, PairKind kind>
  KERNEL unsigned look(const ContactBlock<R>& block, R most) const {
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>;
    unsigned found = 0;
    for (int k = 0; k < kPairBlock; k += lanes) {
      S gap;
      load(block.gap + k, gap);
      const S none = S(R(INFINITY)), keeps = kept_of(gap, rules.least);
      if (movemask((gap < none) & (gap - keeps <= S(most))) == 0) continue;
      Vector3<S> n;
      load(block.n[0] + k, n.x), load(block.n[1] + k, n.y), load(block.n[2] + k, n.z);
      S side[4], unused;
      for (int j = 0; j < 4; ++j) {
        Vector3<S> m;
        gather_rows(motions.moved, block.i[j] + k, m, unused);
        side[j] = dot(n, m);
      }
      const unsigned bad = movemask((gap + gap_along_normal<kind>(side) < keeps) & (gap < none));
      if (bad == 0) continue;
      Vector3<S> x[4];
      for (int j = 0; j < 4; ++j) {
        gather_rows(motions.x0, block.i[j] + k, x[j], unused);
        side[j] = side[j] + dot(n, x[j] - x[0]);
      }
      found |= (bad & movemask(gap_along_normal<kind>(side) < keeps)) << k;
    }
    return found;
  }

  /// What a crossing pair counts as; nothing where all that can move is held.
  KERNEL ViolationCount left_of(const ContactBlock<R>& block, int k) const {
    int fixed = 1;
    for (int j = 0; j < 4; ++j) {
      const int i = block.i[j][k] / kIndexScale<R>;
      if (!(motions.moved[i].w > R(0))) continue;
      if (held == nullptr || held[i] < MotionState::Truncated) return {1, 0};
      fixed = 0;
    }
    return {0, fixed};
  }

  KERNEL void add(ContactBlock<R>& block, int k, int section, PairBits& bits) const {
    // What an earlier look left of those that are not near is no contact.
    for (int l = 0; l < kPairBlock; ++l)
      if (!(bits.near >> l & 1)) clear(block, l);
    bits.near |= static_cast<unsigned short>(1u << k);
    const ContactFrameDouble<R> exact(motions.x0, block, k, first_side_of(section));
    block.n[0][k] = exact.n.x, block.n[1][k] = exact.n.y, block.n[2][k] = exact.n.z;
    for (int j = 0; j < 3; ++j) block.w[j][k] = exact.w[1 + j];
    const R lacks = least_distance(motions, block, k) - exact.distance;
    block.bias[k] = lacks > R(0) ? rules.recovery * lacks : lacks;
  }
  KERNEL static void clear(ContactBlock<R>& block, int k) {
    for (int j = 0; j < 3; ++j) block.w[j][k] = block.friction_impulse[j][k] = R(0);
    block.bias[k] = -R(INFINITY), block.lambda[k] = R(0);
  }
};

/// Calls f(block, k, section) for every pair of a patch that is about to cross, if any of them can be helped. Of a
/// block of threads each has some of them.
template <class R, class Group, class F>
KERNEL void for_each_crossing(const Group& group, const Pairs<R>& pairs, const ViolationCount* left, const F& f) {
  if (left[group.index].free == 0) return;
  const PairPatch patch = pairs.patches[group.index];
  group.for_each(patch.all(), [&](int of) KERNEL_LAMBDA {
    const int b = patch.begin + of, section = patch.section_of(of);
    for (unsigned bits = pairs.bits[b].crossing; bits != 0; bits &= bits - 1)
      f(pairs.blocks[b], lowest_bit(bits), section);
  });
}

/// Of all patches.
template <class R>
struct SumLeft {
  Pairs<R> pairs;
  const ViolationCount* left;
  KERNEL ViolationCount operator()(int u) const { return pairs.patches[u].all() > 0 ? left[u] : ViolationCount{}; }
};

/// The particles of crossing pairs are to be held: whoever writes it, it is the same. Groups: patches of one phase.
template <class R>
struct MarkViolating {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  Trajectories<R> motions;
  Pairs<R> pairs;
  const ViolationCount* left;
  MotionState* held;
  R* part;  // of its motion, that a particle may keep
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for_each_crossing(group, pairs, left, [&](const ContactBlock<R>& block, int k, int) KERNEL_LAMBDA {
      for (int j = 0; j < 4; ++j) {
        const int i = block.i[j][k] / kIndexScale<R>;
        if (held[i] < MotionState::Truncating && motions.moved[i].w > R(0))
          held[i] = MotionState::Truncating, part[i] = R(1);
      }
    });
  }
};

/// They go only as far, beside the motion of what is held, as none of their pairs can be broken by it. Groups: patches
/// of one phase.
template <class R>
struct ComputeTruncation {
  using Shared = void;
  static constexpr int kMostThreads = 32;  // half of them have a pair of a block
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  const MotionState* held;
  R* part;
  Vector3<R> rest;  // motion of what is held, m
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    constexpr int lanes = kLanes<R, Isa>;
    pairs.patches[group.index].for_each_block([&](int b, int section) KERNEL_LAMBDA {
      prefetch_planes(pairs.blocks + b + kBlocksAhead);
      group.for_each(kPairBlock / lanes, [&](int pack) KERNEL_LAMBDA {
        section == 0 ? limit<Isa, PairKind::Face>(pairs.blocks[b], pack * lanes)
                     : limit<Isa, PairKind::Edges>(pairs.blocks[b], pack * lanes);
      });
    });
  }

 private:
  template <class Isa, PairKind kind>
  KERNEL void limit(const ContactBlock<R>& block, int k) const {
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>, first = first_side(kind);
    unsigned limited[4], any = 0;  // a bit a lane
    for (int j = 0; j < 4; ++j) {
      limited[j] = 0;
      for (int l = 0; l < lanes; ++l)
        limited[j] |= unsigned(held[block.i[j][k + l] / kIndexScale<R>] == MotionState::Truncating) << l;
      any |= limited[j];
    }
    if (any == 0) return;
    S gap, unused;
    load(block.gap + k, gap);
    any &= movemask(gap < S(R(INFINITY)));
    if (any == 0) return;
    Vector3<S> n, x[4];
    load(block.n[0] + k, n.x), load(block.n[1] + k, n.y), load(block.n[2] + k, n.z);
    ContactSides<S> sides;
    S at[4];
    for (int j = 0; j < 4; ++j) {
      gather_rows(motions.x0, block.i[j] + k, x[j], unused);
      at[j] = dot(n, x[j] - x[0]);
      sides.add(j, first, at[j]);
    }
    // Half of what the gap may lose is each side's, and what lies behind its plane may come up to it.
    const S zero(R(0)), half = S(R(0.499)) * (gap - kept_of(gap, rules.least));
    for (int j = 0; j < 4; ++j) {
      if ((limited[j] & any) == 0) continue;
      Vector3<S> m;
      gather_rows(motions.moved, block.i[j] + k, m, unused);
      const S along = dot(n, m - Vector3<S>{S(rest.x), S(rest.y), S(rest.z)});
      const S space = j < first ? at[j] - sides.low + half : sides.high - at[j] + half;
      const S nearing = j < first ? -along : along, most = select(space > zero, space / nearing, zero);
      for (unsigned bits = movemask(nearing > space) & limited[j] & any; bits != 0; bits &= bits - 1) {
        const int l = lowest_bit(bits), i = block.i[j][k + l] / kIndexScale<R>;
        part[i] = min(part[i], lane(most, l));
      }
    }
  }
};

/// Puts them there.
template <class R>
struct TruncateDisplacements {
  Trajectories<R> motions;
  Displaced<R> p;
  const R* part;
  MotionState* held;
  Vector3<R> rest;
  KERNEL void operator()(int i) const {
    if (held[i] != MotionState::Truncating) return;
    const Vector3<R> x0 = motions.x0[i].xyz();
    p.set_displacement_from(i, x0, motions.origin, rest + (motions.moved[i].xyz() - rest) * part[i]);
    motions.moved[i].set(p.displacement_from(i, x0, motions.origin));
    held[i] = MotionState::Truncated;
  }
};

}  // namespace malha
