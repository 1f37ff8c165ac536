// SPDX-License-Identifier: Apache-2.0
// Narrow phase of the candidates of a patch: the plane between the sides of each, and which are so near that their
// contact may push.
#pragma once
#include "kernels/self_collision/contact_block.h"
#include "kernels/self_collision/self_contact.h"

namespace malha {

/// How near a pair may be: as its search wants it, or nearer where its particles' contact distances are smaller.
template <class R>
KERNEL R least_distance(const Trajectories<R>& motions, const ContactBlock<R>& block, int k) {
  R least = block.min_distance[k];
  for (int j = 0; j < 4; ++j) least = min(least, motions.x0[block.i[j][k] / kIndexScale<R>].w);
  return least;
}

/// What decides what is near.
template <class R>
struct ContactParams {
  R recovery;  // of a distance below the wanted one, this share is made up for in a substep
  R ahead;     // m: what comes as near as this may still be pushed
  R least;     // m: no gap closes further
};

/// One pair in double.
template <class R>
struct ContactFrameDouble {
  Vector3<R> n{R(0), R(0), R(0)};
  R w[4] = {}, distance = R(0), gap = R(INFINITY);  // as they are where the sides touch: neither is known

  /// The k-th of a block; `first`: particles of the one side.
  KERNEL ContactFrameDouble(const Vec4<R>* x0, const ContactBlock<R>& block, int k, int first_of) : first(first_of) {
    for (int j = 0; j < 4; ++j) x[j] = in_double(x0[block.i[j][k] / kIndexScale<R>].xyz());
    double weight[4];
    EvaluateCandidate<R>::weigh(first, x, weight);
    const Vector3<double> apart = EvaluateCandidate<R>::between(x, weight);
    const double exact = sqrt(dot(apart, apart));
    if (!(exact > 0)) return;
    stand(apart, weight);
    distance = R(exact), gap = R(gap_of(x));
  }

  /// Turns n to the normal where the motion ends, or half the way there, if along it the sides are apart by half of
  /// what they are now, or of what is wanted, at the start and at the end. The distance is then that along n.
  KERNEL void turn(const Vec4<R>* moved, const ContactBlock<R>& block, int k) {
    const double enough = 0.5 * min(double(distance), double(block.min_distance[k]));
    const ContactFrameDouble before = *this;
    Vector3<double> end[4];
    double weight[4];
    for (int j = 0; j < 4; ++j) end[j] = x[j] + in_double(moved[block.i[j][k] / kIndexScale<R>].xyz());
    EvaluateCandidate<R>::weigh(first, end, weight);
    const Vector3<double> there = unit(EvaluateCandidate<R>::between(end, weight));
    stand(there, weight);
    if (!(gap_of(x) > enough)) {
      for (int j = 0; j < 4; ++j) weight[j] = double(before.w[j]);
      stand(unit(there + in_double(before.n)), weight);
      if (!(min(gap_of(x), gap_of(end)) > enough)) {
        *this = before;
        return;
      }
    }
    gap = R(gap_of(x)), distance = R(dot(in_double(n), EvaluateCandidate<R>::between(x, weight)));
  }

 private:
  KERNEL void stand(const Vector3<double>& along, const double* weight) {
    n = rounded<R>(unit(along));
    for (int j = 0; j < 4; ++j) w[j] = R(weight[j]);
  }
  /// Between planes along n, as it is stored, that hold the sides apart.
  KERNEL double gap_of(const Vector3<double>* at) const {
    ContactSides<double> sides;
    for (int j = 0; j < 4; ++j) sides.add(j, first, dot(in_double(n), at[j] - at[0]));
    return sides.low - sides.high;
  }
  KERNEL static Vector3<double> unit(const Vector3<double>& a) { return a * (1 / sqrt(dot(a, a))); }

  int first;
  Vector3<double> x[4];
};

template <class R>
struct NarrowPhase {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  Trajectories<R> motions;
  Pairs<R> pairs;
  ContactParams<R> rules;
  R* room;  // of each patch, by which its gaps may close at least (m)

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    const PairPatch patch = pairs.patches[group.index];
    room[group.index] = group.reduce(
        patch.all(), R(INFINITY),
        [&](int k) KERNEL_LAMBDA {
          const int b = patch.begin + k, section = patch.section_of(k);
          const ContactBlock<R>* const ahead = pairs.blocks + b + kBlocksAhead;
          prefetch(ahead->i, int(sizeof(ahead->i) + sizeof(ahead->min_distance)));
          return section == 0 ? look<Isa, PairKind::Face>(pairs.blocks[b], pairs.bits[b], false)
                              : look<Isa, PairKind::Edges>(pairs.blocks[b], pairs.bits[b], section == 2);
        },
        [](R& least, R of_block) KERNEL_LAMBDA { least = min(least, of_block); });
  }

 private:
  template <class S>
  struct Seen {
    Vector3<S> n;
    S w[4], distance, gap;
  };

  /// Gives by which the gaps of the block may close at least.
  template <class Isa, PairKind kind>
  KERNEL R look(ContactBlock<R>& block, PairBits& of, bool wire_edge) const {
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>;
    const S zero = S(R(0)), none = S(R(INFINITY));
    S closest = none;
    unsigned found = 0, rim = 0;
    for (int k = 0; k < kPairBlock; k += lanes) {
      Vector3<S> x[4], m[4];
      S contact_distance[4], unused, min_distance;
      for (int j = 0; j < 4; ++j) gather_rows(motions.x0, block.i[j] + k, x[j], contact_distance[j]);
      Seen<S> seen;
      const auto inside = weigh<kind>(x, seen.w);
      const Vector3<S> e1 = x[1] - x[0], e2 = x[2] - x[0], e3 = x[3] - x[0];
      const Vector3<S> apart = closest_difference(x, seen.w);
      const S d2 = dot(apart, apart);
      seen.distance = sqrt(d2);
      seen.n = apart * (S(R(1)) / seen.distance);
      const S side[4] = {zero, dot(seen.n, e1), dot(seen.n, e2), dot(seen.n, e3)};
      seen.gap = gap_along_normal<kind>(side);
      load(block.min_distance + k, min_distance);
      for (const S& least : contact_distance) min_distance = min(min_distance, least);
      const auto there = min_distance > -none;
      // In double where a normal from differences in float would lean so much that planes along it let the pair creep
      // through itself.
      constexpr R kFine = sizeof(R) == 4 ? R(1e-6) : R(0);
      const S size2 = max(dot(e1, e1), max(dot(e2, e2), dot(e3, e3)));
      const unsigned clear = movemask((d2 > S(kFine) * size2) & (seen.gap > zero));
      for (unsigned rough = movemask(there) & ~clear; rough != 0; rough &= rough - 1)
        recompute_in_double<kind>(block, k, lowest_bit(rough), seen, false);
      seen.gap = select(there, seen.gap, none);
      const auto plane = seen.gap < none;

      for (int j = 0; j < 4; ++j) gather_rows(motions.moved, block.i[j] + k, m[j], unused);
      const Vector3<S> motion = m[0] * seen.w[0] + m[1] * seen.w[1] + m[2] * seen.w[2] + m[3] * seen.w[3];
      const S along = dot(seen.n, motion), violation = min_distance - seen.distance - along;
      auto near = (violation + S(rules.ahead) > zero) & plane & there;
      // What is nearest at the end of an edge is a pair of its particle with a triangle, where there is one.
      if (kind == PairKind::Edges && !wire_edge) near = near & inside;
      const unsigned bits = movemask(near);
      // Where n is oblique, its plane would stop what slides past a rim or a corner: over a slide t the distance grows
      // by t^2 / (2 distance) beyond that along n. Jitter at rest must not trigger this.
      const Vector3<S> slide = motion - seen.n * along;
      const S tenth = seen.distance * S(R(0.1));
      const auto at_rim = (seen.w[1] == zero) | (seen.w[2] == zero) | (seen.w[3] == zero) | (seen.w[0] == zero);
      for (unsigned past =
               bits & movemask(at_rim & (violation > zero) & (dot(slide, slide) > tenth * max(violation, tenth)));
           past != 0; past &= past - 1)
        recompute_in_double<kind>(block, k, lowest_bit(past), seen, true);
      store(seen.gap, block.gap + k);
      store(seen.n.x, block.n[0] + k), store(seen.n.y, block.n[1] + k), store(seen.n.z, block.n[2] + k);
      closest = min(closest, select(plane, seen.gap - kept_of(seen.gap, rules.least), none));
      if (bits == 0) continue;
      found |= bits << k, rim |= (bits & movemask(at_rim)) << k;
      const S lacks = min_distance - seen.distance;
      for (int j = 0; j < 3; ++j) store(seen.w[1 + j], block.w[j] + k), store(zero, block.friction_impulse[j] + k);
      store(select(near, select(lacks > zero, lacks * S(rules.recovery), lacks), -none), block.bias + k);
      store(zero, block.lambda + k);
    }
    of.near = static_cast<unsigned short>(found), of.rim = static_cast<unsigned short>(rim);
    R least = R(INFINITY);
    for (int l = 0; l < lanes; ++l) least = min(least, lane(closest, l));
    return least;
  }

  template <PairKind kind, class S>
  KERNEL void recompute_in_double(const ContactBlock<R>& block, int k, int l, Seen<S>& seen, bool turns) const {
    ContactFrameDouble<R> exact(motions.x0, block, k + l, first_side(kind));
    if (turns) exact.turn(motions.moved, block, k + l);
    set_lane(seen.n.x, l, exact.n.x), set_lane(seen.n.y, l, exact.n.y), set_lane(seen.n.z, l, exact.n.z);
    set_lane(seen.distance, l, exact.distance), set_lane(seen.gap, l, exact.gap);
    for (int j = 0; j < 4; ++j) set_lane(seen.w[j], l, exact.w[j]);
  }
};

}  // namespace malha
