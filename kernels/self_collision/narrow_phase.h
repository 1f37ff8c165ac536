// SPDX-License-Identifier: Apache-2.0
// Narrow phase of the candidates of a patch: the division plane of each pair, and which pairs are near enough to be
// contacts.
#pragma once
#include "kernels/self_collision/contact_block.h"
#include "kernels/self_collision/division_plane.h"

namespace malha {

/// The distance that a pair must keep, m: that of the broad phase, or the contact distance of a particle if that is
/// less.
template <class R>
KERNEL R least_distance(const Trajectories<R>& motions, const ContactBlock<R>& block, int k) {
  R least = block.min_distance[k];
  for (int j = 0; j < 4; ++j) least = min(least, motions.x0[block.i[j][k] / kIndexScale<R>].w);
  return least;
}

/// Parameters of contacts.
template <class R>
struct ContactParams {
  R recovery;  // share of a violation of the minimum distance that is recovered in a substep
  R ahead;     // m: a pair that comes nearer than its minimum distance plus this is a contact
  R least;     // m: lower bound of the gap that truncation leaves
};

/// Rows of the particles of pair k of a block, in double.
template <class R>
struct PairRows {
  Vector3<double> of[4];
  KERNEL PairRows(const Vec4<R>* rows, const ContactBlock<R>& block, int k) {
    for (int j = 0; j < 4; ++j) of[j] = in_double(rows[block.i[j][k] / kIndexScale<R>].xyz());
  }
};

template <class R>
struct NarrowPhase {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  R* closable_gap;  // of each patch: least motion that closes one of its gaps, m

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    const PairPatch patch = pairs.patches[group.index];
    closable_gap[group.index] = group.reduce(
        patch.all(), R(INFINITY),
        [&](int k) KERNEL_LAMBDA {
          const int b = patch.begin + k, section = patch.section_of(k);
          const ContactBlock<R>* const ahead = pairs.blocks + b + kBlocksAhead;
          prefetch(ahead->i, int(sizeof(ahead->i) + sizeof(ahead->min_distance)));
          return section == 0 ? evaluate_block<Isa, PairKind::Face>(pairs.blocks[b], pairs.bits[b], false)
                              : evaluate_block<Isa, PairKind::Edges>(pairs.blocks[b], pairs.bits[b], section == 2);
        },
        [](R& least, R of_block) KERNEL_LAMBDA { least = min(least, of_block); });
  }

 private:
  template <class S>
  struct PairGeometry {
    Vector3<S> n;
    S w[4], distance, gap;
  };

  /// Evaluates a block. Returns the least motion that closes one of its gaps, m.
  template <class Isa, PairKind kind>
  KERNEL R evaluate_block(ContactBlock<R>& block, PairBits& flags, bool wire_edge) const {
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>;
    const S zero = S(R(0)), none = S(R(INFINITY));
    S closest = none;
    unsigned found = 0, rim = 0;
    for (int k = 0; k < kPairBlock; k += lanes) {
      Vector3<S> x[4], m[4];
      S contact_distance[4], unused, min_distance;
      for (int j = 0; j < 4; ++j) gather_rows(motions.x0, block.i[j] + k, x[j], contact_distance[j]);
      PairGeometry<S> pair;
      const auto inside = weigh<kind>(x, pair.w);
      const Vector3<S> e1 = x[1] - x[0], e2 = x[2] - x[0], e3 = x[3] - x[0];
      const Vector3<S> apart = closest_offset(x, pair.w);
      const S d2 = dot(apart, apart);
      pair.distance = sqrt(d2);
      pair.n = apart * (S(R(1)) / pair.distance);
      const S side[4] = {zero, dot(pair.n, e1), dot(pair.n, e2), dot(pair.n, e3)};
      pair.gap = gap_along_normal<kind>(side);
      load(block.min_distance + k, min_distance);
      for (const S& least : contact_distance) min_distance = min(min_distance, least);
      const auto is_pair = min_distance > -none;
      // In double where a normal from differences in float would be so oblique that the pair could creep through its
      // planes.
      constexpr R kFine = sizeof(R) == 4 ? R(1e-6) : R(0);
      const S size2 = max(dot(e1, e1), max(dot(e2, e2), dot(e3, e3)));
      const unsigned precise = movemask((d2 > S(kFine) * size2) & (pair.gap > zero));
      for (unsigned imprecise = movemask(is_pair) & ~precise; imprecise != 0; imprecise &= imprecise - 1)
        recompute_in_double<kind>(block, k, lowest_bit(imprecise), pair, false);
      pair.gap = select(is_pair, pair.gap, none);
      const auto plane = pair.gap < none;

      for (int j = 0; j < 4; ++j) gather_rows(motions.moved, block.i[j] + k, m[j], unused);
      const Vector3<S> motion = m[0] * pair.w[0] + m[1] * pair.w[1] + m[2] * pair.w[2] + m[3] * pair.w[3];
      const S along = dot(pair.n, motion), violation = min_distance - pair.distance - along;
      auto near = (violation + S(rules.ahead) > zero) & plane & is_pair;
      // If the closest point is the end of an edge, the pair of its particle and a triangle is used where there is one.
      if (kind == PairKind::Edges && !wire_edge) near = near & inside;
      const unsigned bits = movemask(near);
      // Where n is oblique, its plane would stop what slides past a rim or a corner: over a slide t the distance grows
      // by t^2 / (2 distance) beyond that along n. Jitter at rest must not trigger this.
      const Vector3<S> slide = motion - pair.n * along;
      const S tenth = pair.distance * S(R(0.1));
      const auto at_rim = (pair.w[1] == zero) | (pair.w[2] == zero) | (pair.w[3] == zero) | (pair.w[0] == zero);
      for (unsigned sliding =
               bits & movemask(at_rim & (violation > zero) & (dot(slide, slide) > tenth * max(violation, tenth)));
           sliding != 0; sliding &= sliding - 1)
        recompute_in_double<kind>(block, k, lowest_bit(sliding), pair, true);
      store(pair.gap, block.gap + k);
      store(pair.n.x, block.n[0] + k), store(pair.n.y, block.n[1] + k), store(pair.n.z, block.n[2] + k);
      closest = min(closest, select(plane, pair.gap - required_gap(pair.gap, rules.least), none));
      if (bits == 0) continue;
      found |= bits << k, rim |= (bits & movemask(at_rim)) << k;
      const S missing = min_distance - pair.distance;
      for (int j = 0; j < 3; ++j) store(pair.w[1 + j], block.w[j] + k), store(zero, block.friction_impulse[j] + k);
      store(select(near, select(missing > zero, missing * S(rules.recovery), missing), -none), block.bias + k);
      store(zero, block.lambda + k);
    }
    flags.near = static_cast<unsigned short>(found), flags.rim = static_cast<unsigned short>(rim);
    R least = R(INFINITY);
    for (int l = 0; l < lanes; ++l) least = min(least, lane(closest, l));
    return least;
  }

  template <PairKind kind, class S>
  KERNEL void recompute_in_double(const ContactBlock<R>& block, int k, int l, PairGeometry<S>& pair, bool turns) const {
    ContactFrameDouble<R> exact(PairRows<R>(motions.x0, block, k + l).of, first_side(kind));
    if (turns) exact.turn(PairRows<R>(motions.moved, block, k + l).of, block.min_distance[k + l]);
    set_lane(pair.n.x, l, exact.n.x), set_lane(pair.n.y, l, exact.n.y), set_lane(pair.n.z, l, exact.n.z);
    set_lane(pair.distance, l, exact.distance), set_lane(pair.gap, l, exact.gap);
    for (int j = 0; j < 4; ++j) set_lane(pair.w[j], l, exact.w[j]);
  }
};

}  // namespace malha
