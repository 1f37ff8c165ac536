// SPDX-License-Identifier: Apache-2.0
// Broad phase: which pairs (a particle and a triangle, or two edges) can come nearer than is wanted while every
// particle stays in the box of its search.
#pragma once
#include "kernels/self_collision/cluster_bvh.h"
#include "kernels/self_collision/contact_packing.h"

namespace malha {

/// Of what, and how near.
template <class R>
struct BroadPhaseQuery {
  ClusterBvh<R> units;
  SweptBounds<R> reach;
  R thickness;
  bool has_bare;                  // whether any edge has no triangle
  const CrossingBodies* crosses;  // at each particle; none: nothing crosses
  Pairs<R> pairs;

  /// Unit u owns its pairs with itself, and of two units every other one.
  KERNEL static bool owns(int u, int v) { return u == v || (((u + v) & 1) == 1) == (u < v); }

  /// The particles of items i and j, kIndexScale times each; whether the pair is one: its sides share no particle, and
  /// an edge without a triangle is among them or not, as `bare` says. Without a branch, because many do.
  template <PairKind kind>
  KERNEL bool particles(int i, int j, bool wire_edge, int (&c)[4]) const {
    bool apart;
    if constexpr (kind == PairKind::Face) {
      c[0] = units.point[i], c[1] = units.corner[0][j], c[2] = units.corner[1][j], c[3] = units.corner[2][j];
      apart = (c[0] != c[1]) & (c[0] != c[2]) & (c[0] != c[3]);
    } else {
      c[0] = units.end[0][i], c[1] = units.end[1][i], c[2] = units.end[0][j], c[3] = units.end[1][j];
      apart = (c[0] != c[2]) & (c[0] != c[3]) & (c[1] != c[2]) & (c[1] != c[3]);
      if (has_bare) apart = apart && bool(units.wire_edge[i] | units.wire_edge[j]) == wire_edge;
    }
    return apart;
  }
};

/// What the sides of pairs are: a kind of items each, of which the first may be the other unit's.
template <PairKind kind>
inline constexpr ClusterItems kOneSide = kind == PairKind::Face ? kPoints : kEdges;
template <PairKind kind>
inline constexpr ClusterItems kOtherSide = kind == PairKind::Face ? kTriangles : kEdges;

/// Pairs that wait until there are as many as a block holds: the particles of each.
struct CandidateQueue {
  int of[4][2 * kPairBlock], count = 0;
  KERNEL void add(const int (&i)[4], bool counts) {
    for (int j = 0; j < 4; ++j) of[j][count] = i[j];
    count += counts;
  }
  KERNEL void take(const CandidateQueue& from, int k) {
    for (int j = 0; j < 4; ++j) of[j][count] = from.of[j][k];
    ++count;
  }
  /// Fills up the first block.
  KERNEL void pad(int padding) {
    for (int k = count; k < kPairBlock; ++k)
      for (int j = 0; j < 4; ++j) of[j][k] = padding;
  }
  KERNEL PairIndices from(int k) const { return {{of[0] + k, of[1] + k, of[2] + k, of[3] + k}}; }
  /// A bit for each of k, k + 1, ... that is there.
  KERNEL unsigned there(int k, int lanes) const {
    const int left = count - k;
    return left <= 0 ? 0 : left >= lanes ? ~0u : (1u << left) - 1;
  }
  /// Takes the first block away.
  KERNEL void drop() {
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < kPairBlock; ++k) of[j][k] = of[j][kPairBlock + k];
    count = count > kPairBlock ? count - kPairBlock : 0;
  }
};

/// Finds the pairs that each unit owns: a core a unit, in packs. kernels/self_collision/broad_phase_cooperative.h is
/// for a device.
template <class R>
struct FindCandidates {
  BroadPhaseQuery<R> of;
  DirectIndexMap places;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    Finder<typename Group::Isa> finder(of, group.index, places.of(group.memory));
    finder.template find<PairKind::Face>(0, false);
    finder.template find<PairKind::Edges>(1, false);
    if (of.has_bare) finder.template find<PairKind::Edges>(2, true);
    finder.placed.finish(group.index);
  }

 private:
  template <class Isa>
  struct Finder {
    using S = Lane<R, Isa>;
    static constexpr int lanes = kLanes<R, Isa>;

    const BroadPhaseQuery<R>& of;
    const int u;
    ContactBlockBuilder<R, DirectIndexMap::Places> placed;
    CandidateQueue candidates, near;  // near: of the candidates, what comes as near as the thickness
    R least_of[2 * kPairBlock];       // and how near

    KERNEL Finder(const BroadPhaseQuery<R>& question, int unit, const DirectIndexMap::Places& places)
        : of(question), u(unit) {
      placed.start(of.pairs, unit, places);
    }

    template <PairKind kind>
    KERNEL void find(int section, bool wire_edge) {
      for_each_overlapping_cluster<Isa>(of.units, u, [&](int v) KERNEL_LAMBDA {
        if (!of.owns(u, v)) return;
        const int turns = kind == PairKind::Face && v != u ? 2 : 1;
        for (int turn = 0; turn < turns; ++turn)
          for_each_overlapping_pair<Isa>(of.units, turn == 0 ? u : v, kOneSide<kind>, turn == 0 ? v : u,
                                         kOtherSide<kind>, [&](int i, int first, unsigned bits) KERNEL_LAMBDA {
                                           for (; bits != 0; bits &= bits - 1)
                                             add<kind>(i, first + lowest_bit(bits), wire_edge);
                                           if (candidates.count >= kPairBlock) look<kind>();
                                         });
      });
      if (candidates.count > 0) look<kind>();
      if (near.count > 0) keep<kind>();
      placed.end_section(section);
    }

    template <PairKind kind>
    KERNEL void add(int i, int j, bool wire_edge) {
      int c[4];
      const bool is_one = of.template particles<kind>(i, j, wire_edge, c);
      candidates.add(c, is_one);
    }

    /// Of the candidates, those that can come as near as the thickness.
    template <PairKind kind>
    KERNEL void look() {
      candidates.pad(of.pairs.padding);
      placed.patch.candidates += candidates.count < kPairBlock ? candidates.count : kPairBlock;
      for (int k = 0; k < kPairBlock; k += lanes) {
        const S least = min_swept_distance<kind, S>(of.reach, candidates.from(k));
        for (unsigned bits = movemask(least <= S(of.thickness)) & candidates.there(k, lanes); bits != 0;
             bits &= bits - 1) {
          const int l = lowest_bit(bits);
          least_of[near.count] = lane(least, l);
          near.take(candidates, k + l);
        }
      }
      candidates.drop();
      if (near.count >= kPairBlock) keep<kind>();
    }

    /// Of those, the ones that can come as near as is wanted get places.
    template <PairKind kind>
    KERNEL void keep() {
      near.pad(of.pairs.padding);
      for (int k = 0; k < kPairBlock; k += lanes) {
        S least;
        load(least_of + k, least);
        const S min_distance = required_distance<kind, S>(of.reach, of.thickness, near.from(k));
        for (unsigned bits = movemask(least <= min_distance) & near.there(k, lanes); bits != 0; bits &= bits - 1) {
          const int l = lowest_bit(bits);
          place<kind>(k + l, lane(min_distance, l));
        }
      }
      near.drop();
      for (int k = 0; k < kPairBlock; ++k) least_of[k] = least_of[kPairBlock + k];
    }

    template <PairKind kind>
    KERNEL void place(int k, R min_distance) {
      const int i[4] = {near.of[0][k], near.of[1][k], near.of[2][k], near.of[3][k]};
      if (of.crosses == nullptr || !cross_at_both_sides<kind>(of.reach, of.crosses, i)) placed.add(i, min_distance);
    }
  };
};

}  // namespace malha
