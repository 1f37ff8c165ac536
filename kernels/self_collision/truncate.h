// SPDX-License-Identifier: Apache-2.0
// Final guard of a substep: displacements are truncated so that no pair of primitives intersects. At x0 none does.
// Every pair that could come near is a candidate, because no particle leaves its swept bounds. A pair stays separated
// if a plane of normal n is between its sides at the end as at the start: every particle moves along a line, so that an
// interpolated plane separates the sides at every time between. If a pair violates this, the displacements of its
// particles are truncated, each to its side's half of the gap. Pairs that this causes to violate are truncated next,
// until none is left. This follows the truncation of Chen et al., "Offset Geometric Contact" (2025), with two changes:
// a displacement is bounded by planes, not by a ball, so that layers slide freely; and only pairs that would intersect
// are truncated, so that a motion that all particles have in common is not slowed down.
#pragma once
#include "kernels/self_collision/narrow_phase.h"
#include "kernels/simd/particles.h"

namespace malha {

/// State of a particle in the final guard of a substep. Unchanged: the guard has not touched it. Pushing: it is a
/// moving fixed particle, or a push has moved it, and it pushes others out of its way. Truncating: its truncation is
/// being computed. Truncated: its displacement is truncated. Kinematic: it moves with a fixed particle. The order
/// counts: a particle before Truncated can still be truncated.
enum class MotionState : unsigned char { Unchanged, Pushing, Truncating, Truncated, Kinematic };

/// Number of pairs that would intersect. `resolvable`: pairs that truncation can still resolve. `immovable`: pairs
/// whose particles are all fixed, which it cannot.
struct ViolationCount {
  int resolvable = 0, immovable = 0;
  KERNEL ViolationCount& operator+=(const ViolationCount& o) {
    resolvable += o.resolvable, immovable += o.immovable;
    return *this;
  }
};

/// Marks the pairs of a patch that would intersect, and counts them. If `adds`, a marked pair becomes a contact.
template <class R>
struct FindViolations {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  const R* closable_gap;
  bool adds;
  const MotionState* states;   // null: no particle is truncated yet
  ViolationCount* violations;  // of each patch

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    const PairPatch patch = pairs.patches[group.index];
    const R max_closing = max_closing_motion(group, patch);
    if (closable_gap[group.index] > max_closing) {
      violations[group.index] = {};
      return;
    }
    const bool reads_most =
        max_closing > R(10) * rules.ahead;  // if particles move by about the thickness, most blocks are read
    violations[group.index] = group.reduce(
        patch.all(), ViolationCount{},
        [&](int k) KERNEL_LAMBDA {
          if (reads_most) prefetch_planes(pairs.blocks + patch.begin + k + kBlocksAhead);
          return find_in_block<Isa>(patch.begin + k, patch.section_of(k), max_closing);
        },
        [](ViolationCount& count, const ViolationCount& of_block) KERNEL_LAMBDA { count += of_block; });
  }

 private:
  /// Upper bound of the length by which any gap of the patch can close in the substep (m): twice the largest
  /// displacement relative to the first particle, because both sides of a pair move.
  template <class Group>
  KERNEL R max_closing_motion(const Group& group, const PairPatch& patch) const {
    const int* const of = pairs.patch_particles + patch.particles_begin;
    const Vector3<R> first = motions.moved[of[0]].xyz();
    const R max_closing2 = group.reduce(
        patch.particle_count, R(0),
        [&](int k) KERNEL_LAMBDA {
          const Vector3<R> beside = motions.moved[of[k]].xyz() - first;
          return dot(beside, beside);
        },
        [](R& max_closing, R one) KERNEL_LAMBDA { max_closing = max(one, max_closing); });
    return R(2.001) * sqrt(max_closing2);
  }

  template <class Isa>
  KERNEL ViolationCount find_in_block(int b, int section, R max_closing) const {
    ContactBlock<R>& block = pairs.blocks[b];
    const unsigned found = section == 0 ? find_in_block<Isa, PairKind::Face>(block, max_closing)
                                        : find_in_block<Isa, PairKind::Edges>(block, max_closing);
    pairs.bits[b].crossing = static_cast<unsigned short>(found);
    ViolationCount count;
    for (unsigned bits = found; bits != 0; bits &= bits - 1) {
      const int k = lowest_bit(bits);
      const ViolationCount one = violations_of(block, k);
      count += one;
      if (one.resolvable > 0 && adds && !(pairs.bits[b].near >> k & 1)) add(block, k, section, pairs.bits[b]);
    }
    return count;
  }

  template <class Isa, PairKind kind>
  KERNEL unsigned find_in_block(const ContactBlock<R>& block, R max_closing) const {
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>;
    unsigned found = 0;
    for (int k = 0; k < kPairBlock; k += lanes) {
      S gap;
      load(block.gap + k, gap);
      const S none = S(R(INFINITY)), required = required_gap(gap, rules.least);
      if (movemask((gap < none) & (gap - required <= S(max_closing))) == 0) continue;
      Vector3<S> n;
      load(block.n[0] + k, n.x), load(block.n[1] + k, n.y), load(block.n[2] + k, n.z);
      S side[4], unused;
      for (int j = 0; j < 4; ++j) {
        Vector3<S> m;
        gather_rows(motions.moved, block.i[j] + k, m, unused);
        side[j] = dot(n, m);
      }
      const unsigned bad = movemask((gap + gap_along_normal<kind>(side) < required) & (gap < none));
      if (bad == 0) continue;
      Vector3<S> x[4];
      for (int j = 0; j < 4; ++j) {
        gather_rows(motions.x0, block.i[j] + k, x[j], unused);
        side[j] = side[j] + dot(n, x[j] - x[0]);
      }
      found |= (bad & movemask(gap_along_normal<kind>(side) < required)) << k;
    }
    return found;
  }

  /// The count of one violating pair: none if all its movable particles are truncated already.
  KERNEL ViolationCount violations_of(const ContactBlock<R>& block, int k) const {
    int immovable = 1;
    for (int j = 0; j < 4; ++j) {
      const int i = block.i[j][k] / kIndexScale<R>;
      if (!(motions.moved[i].w > R(0))) continue;
      if (states == nullptr || states[i] < MotionState::Truncated) return {1, 0};
      immovable = 0;
    }
    return {0, immovable};
  }

  KERNEL void add(ContactBlock<R>& block, int k, int section, PairBits& bits) const {
    // The narrow phase left old data in pairs that are no contacts: clear them.
    for (int l = 0; l < kPairBlock; ++l)
      if (!(bits.near >> l & 1)) clear(block, l);
    bits.near |= static_cast<unsigned short>(1u << k);
    const ContactFrameDouble<R> exact(PairRows<R>(motions.x0, block, k).of, first_side_of(section));
    block.n[0][k] = exact.n.x, block.n[1][k] = exact.n.y, block.n[2][k] = exact.n.z;
    for (int j = 0; j < 3; ++j) block.w[j][k] = exact.w[1 + j];
    const R violation = least_distance(motions, block, k) - exact.distance;
    block.bias[k] = violation > R(0) ? rules.recovery * violation : violation;
  }
  KERNEL static void clear(ContactBlock<R>& block, int k) {
    for (int j = 0; j < 3; ++j) block.w[j][k] = block.friction_impulse[j][k] = R(0);
    block.bias[k] = -R(INFINITY), block.lambda[k] = R(0);
  }
};

/// Calls f(block, k, section) for every pair of a patch that would intersect, if any of them can be resolved. The
/// threads of a block share the pairs.
template <class R, class Group, class F>
KERNEL void for_each_crossing(const Group& group, const Pairs<R>& pairs, const ViolationCount* violations, const F& f) {
  if (violations[group.index].resolvable == 0) return;
  const PairPatch patch = pairs.patches[group.index];
  group.for_each(patch.all(), [&](int of) KERNEL_LAMBDA {
    const int b = patch.begin + of, section = patch.section_of(of);
    for (unsigned bits = pairs.bits[b].crossing; bits != 0; bits &= bits - 1)
      f(pairs.blocks[b], lowest_bit(bits), section);
  });
}

/// Sum of the violations of all patches, as a reduction over patches.
template <class R>
struct SumViolations {
  Pairs<R> pairs;
  const ViolationCount* violations;
  KERNEL ViolationCount operator()(int u) const {
    return pairs.patches[u].all() > 0 ? violations[u] : ViolationCount{};
  }
};

/// Marks the particles of violating pairs as Truncating; concurrent writes store the same value. Groups: patches of one
/// colour.
template <class R>
struct MarkViolating {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  Trajectories<R> motions;
  Pairs<R> pairs;
  const ViolationCount* violations;
  MotionState* states;
  R* fraction;  // the fraction of its displacement that each particle keeps
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for_each_crossing(group, pairs, violations, [&](const ContactBlock<R>& block, int k, int) KERNEL_LAMBDA {
      for (int j = 0; j < 4; ++j) {
        const int i = block.i[j][k] / kIndexScale<R>;
        if (states[i] < MotionState::Truncating && motions.moved[i].w > R(0))
          states[i] = MotionState::Truncating, fraction[i] = R(1);
      }
    });
  }
};

/// Limits the fraction of its displacement, relative to `rest_motion`, that a Truncating particle keeps, so that it
/// alone cannot make any of its pairs intersect. Groups: patches of one colour.
template <class R>
struct ComputeTruncation {
  using Shared = void;
  static constexpr int kMostThreads = 32;  // half of them have a pair of a block
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  const MotionState* states;
  R* fraction;
  Vector3<R> rest_motion;  // motion of truncated particles, m
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    constexpr int lanes = kLanes<R, Isa>;
    pairs.patches[group.index].for_each_block([&](int b, int section) KERNEL_LAMBDA {
      prefetch_planes(pairs.blocks + b + kBlocksAhead);
      group.for_each(kPairBlock / lanes, [&](int pack) KERNEL_LAMBDA {
        section == 0 ? limit_fraction<Isa, PairKind::Face>(pairs.blocks[b], pack * lanes)
                     : limit_fraction<Isa, PairKind::Edges>(pairs.blocks[b], pack * lanes);
      });
    });
  }

 private:
  template <class Isa, PairKind kind>
  KERNEL void limit_fraction(const ContactBlock<R>& block, int k) const {
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>, first = first_side(kind);
    unsigned truncating[4], any = 0;  // a bit for each lane
    for (int j = 0; j < 4; ++j) {
      truncating[j] = 0;
      for (int l = 0; l < lanes; ++l)
        truncating[j] |= unsigned(states[block.i[j][k + l] / kIndexScale<R>] == MotionState::Truncating) << l;
      any |= truncating[j];
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
    // Each side may close half of the excess gap, and particles behind their side's plane may come up to it.
    const S zero(R(0)), half = S(R(0.499)) * (gap - required_gap(gap, rules.least));
    for (int j = 0; j < 4; ++j) {
      if ((truncating[j] & any) == 0) continue;
      Vector3<S> m;
      gather_rows(motions.moved, block.i[j] + k, m, unused);
      const S along = dot(n, m - Vector3<S>{S(rest_motion.x), S(rest_motion.y), S(rest_motion.z)});
      const S allowed = j < first ? at[j] - sides.low + half : sides.high - at[j] + half;
      const S nearing = j < first ? -along : along, max_fraction = select(allowed > zero, allowed / nearing, zero);
      for (unsigned bits = movemask(nearing > allowed) & truncating[j] & any; bits != 0; bits &= bits - 1) {
        const int l = lowest_bit(bits), i = block.i[j][k + l] / kIndexScale<R>;
        fraction[i] = min(fraction[i], lane(max_fraction, l));
      }
    }
  }
};

/// Applies the truncation to the displacements.
template <class R>
struct TruncateDisplacements {
  Trajectories<R> motions;
  Displaced<R> p;
  const R* fraction;
  MotionState* states;
  Vector3<R> rest_motion;
  KERNEL void operator()(int i) const {
    if (states[i] != MotionState::Truncating) return;
    const Vector3<R> x0 = motions.x0[i].xyz();
    p.set_displacement_from(i, x0, motions.origin, rest_motion + (motions.moved[i].xyz() - rest_motion) * fraction[i]);
    motions.moved[i].set(p.displacement_from(i, x0, motions.origin));
    states[i] = MotionState::Truncated;
  }
};

}  // namespace malha
