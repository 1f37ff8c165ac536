// SPDX-License-Identifier: Apache-2.0
// Broad phase of self-collision: the pairs (a particle and a triangle, or two edges) that can come nearer than their
// minimum distance while every particle stays in its swept bounds.
#pragma once
#include "kernels/self_collision/cluster_bvh.h"
#include "kernels/self_collision/contact_packing.h"

namespace malha {

/// For each particle those that seams hold at its place, or at a triangle that they attach to it. Null: none.
struct SewnParticles {
  const int* begin = nullptr;  // in the list, of each particle, one more at the end
  const int* list = nullptr;   // kIndexScale times each
};

/// Query of the broad phase: its input, and which pairs count.
template <class R>
struct BroadPhaseQuery {
  ClusterBvh<R> clusters;
  SweptBounds<R> bounds;
  R thickness;
  const CrossingBodies* crosses;  // of each particle; null: no bodies intersect
  SewnParticles sewn;
  Pairs<R> pairs;

  /// Returns true if a pair does not count: where bodies intersect, and where a seam joins its sides.
  template <PairKind kind>
  KERNEL bool leaves_out(const int (&i)[4]) const {
    if (crosses != nullptr && cross_at_both_sides<kind>(bounds, crosses, i)) return true;
    if (sewn.begin == nullptr) return false;
    bool joined = false;
    for (int j = 0; j < first_side(kind); ++j) {
      const int particle = i[j] / kIndexScale<R>;
      for (int k = sewn.begin[particle]; k < sewn.begin[particle + 1]; ++k)
        for (int other = first_side(kind); other < 4; ++other) joined = joined || sewn.list[k] == i[other];
    }
    return joined;
  }

  /// Returns true if cluster u owns the pairs of clusters u and v. Of two clusters one owns them, by the parity of
  /// their sum, so that all clusters own about as many.
  KERNEL static bool owns(int u, int v) { return u == v || (((u + v) & 1) == 1) == (u < v); }

  /// Stores the particles of items i and j, kIndexScale times each. Returns true if the items form a pair of this
  /// section: they share no particle, and a wire edge is among them exactly if `wire_edge`. Branchless, because most
  /// items overlap.
  template <PairKind kind>
  KERNEL bool particles(int i, int j, bool wire_edge, int (&c)[4]) const {
    bool apart;
    if constexpr (kind == PairKind::Face) {
      c[0] = clusters.point[i], c[1] = clusters.corner[0][j], c[2] = clusters.corner[1][j],
      c[3] = clusters.corner[2][j];
      apart = (c[0] != c[1]) & (c[0] != c[2]) & (c[0] != c[3]);
    } else {
      c[0] = clusters.end[0][i], c[1] = clusters.end[1][i], c[2] = clusters.end[0][j], c[3] = clusters.end[1][j];
      apart = (c[0] != c[2]) & (c[0] != c[3]) & (c[1] != c[2]) & (c[1] != c[3]);
      if (clusters.has_wire_edges) apart = apart && bool(clusters.wire_edge[i] | clusters.wire_edge[j]) == wire_edge;
    }
    return apart;
  }
};

/// Kinds of items of the two sides of a pair; either side may belong to either cluster.
template <PairKind kind>
inline constexpr ClusterItems kOneSide = kind == PairKind::Face ? kPoints : kEdges;
template <PairKind kind>
inline constexpr ClusterItems kOtherSide = kind == PairKind::Face ? kTriangles : kEdges;

/// Queue of pairs that are tested a block at a time; holds the particles of each.
struct CandidateQueue {
  int particles[4][2 * kPairBlock], count = 0;
  KERNEL void add(const int (&i)[4], bool counts) {
    for (int j = 0; j < 4; ++j) particles[j][count] = i[j];
    count += counts;
  }
  KERNEL void append(const CandidateQueue& from, int k) {
    for (int j = 0; j < 4; ++j) particles[j][count] = from.particles[j][k];
    ++count;
  }
  /// Pads the first block.
  KERNEL void pad(int padding) {
    for (int k = count; k < kPairBlock; ++k)
      for (int j = 0; j < 4; ++j) particles[j][k] = padding;
  }
  KERNEL PairIndices from(int k) const {
    return {{particles[0] + k, particles[1] + k, particles[2] + k, particles[3] + k}};
  }
  /// Mask of the valid pairs among k, k + 1, ...
  KERNEL unsigned valid(int k, int lanes) const {
    const int left = count - k;
    return left <= 0 ? 0 : left >= lanes ? ~0u : (1u << left) - 1;
  }
  /// Removes the first block.
  KERNEL void drop() {
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < kPairBlock; ++k) particles[j][k] = particles[j][kPairBlock + k];
    count = count > kPairBlock ? count - kPairBlock : 0;
  }
};

/// Finds the pairs that each cluster owns: a core for each cluster, in packs. A device uses
/// kernels/self_collision/broad_phase_cooperative.h.
template <class R>
struct FindCandidates {
  BroadPhaseQuery<R> query;
  DirectIndexMap index_map;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    Finder<typename Group::Isa> finder(query, group.index, index_map.of(group.memory));
    finder.template find<PairKind::Face>(0, false);
    finder.template find<PairKind::Edges>(1, false);
    if (query.clusters.has_wire_edges) finder.template find<PairKind::Edges>(2, true);
    finder.builder.finish(group.index);
  }

 private:
  template <class Isa>
  struct Finder {
    using S = Lane<R, Isa>;
    static constexpr int lanes = kLanes<R, Isa>;

    const BroadPhaseQuery<R>& query;
    const int u;
    ContactBlockBuilder<R, DirectIndexMap::Map> builder;
    CandidateQueue candidates, near;  // near: candidates that come as near as the thickness
    R distance_of[2 * kPairBlock];    // lower bounds of their distances

    KERNEL Finder(const BroadPhaseQuery<R>& all, int cluster, const DirectIndexMap::Map& index_map)
        : query(all), u(cluster) {
      builder.start(query.pairs, cluster, index_map);
    }

    template <PairKind kind>
    KERNEL void find(int section, bool wire_edge) {
      for_each_overlap<Isa>(query.clusters.tree, query.clusters.tree.node[u], [&](int v) KERNEL_LAMBDA {
        if (!query.owns(u, v)) return;
        const int passes = kind == PairKind::Face && v != u ? 2 : 1;
        for (int pass = 0; pass < passes; ++pass)
          for_each_overlapping_pair<Isa>(query.clusters, pass == 0 ? u : v, kOneSide<kind>, pass == 0 ? v : u,
                                         kOtherSide<kind>, [&](int i, int first, unsigned bits) KERNEL_LAMBDA {
                                           for (; bits != 0; bits &= bits - 1)
                                             add<kind>(i, first + lowest_bit(bits), wire_edge);
                                           if (candidates.count >= kPairBlock) test_candidates<kind>();
                                         });
      });
      if (candidates.count > 0) test_candidates<kind>();
      if (near.count > 0) test_near<kind>();
      builder.end_section(section);
    }

    template <PairKind kind>
    KERNEL void add(int i, int j, bool wire_edge) {
      int c[4];
      const bool is_pair = query.template particles<kind>(i, j, wire_edge, c);
      candidates.add(c, is_pair);
    }

    /// Tests a block of candidates against the thickness.
    template <PairKind kind>
    KERNEL void test_candidates() {
      candidates.pad(query.pairs.padding);
      builder.patch.candidates += candidates.count < kPairBlock ? candidates.count : kPairBlock;
      for (int k = 0; k < kPairBlock; k += lanes) {
        const S distance = min_swept_distance<kind, S>(query.bounds, candidates.from(k));
        for (unsigned bits = movemask(distance <= S(query.thickness)) & candidates.valid(k, lanes); bits != 0;
             bits &= bits - 1) {
          const int l = lowest_bit(bits);
          distance_of[near.count] = lane(distance, l);
          near.append(candidates, k + l);
        }
      }
      candidates.drop();
      if (near.count >= kPairBlock) test_near<kind>();
    }

    /// Tests a block of near candidates against their own minimum distances, and packs those that pass.
    template <PairKind kind>
    KERNEL void test_near() {
      near.pad(query.pairs.padding);
      for (int k = 0; k < kPairBlock; k += lanes) {
        S distance;
        load(distance_of + k, distance);
        const S min_distance = required_distance<kind, S>(query.bounds, query.thickness, near.from(k));
        for (unsigned bits = movemask(distance <= min_distance) & near.valid(k, lanes); bits != 0; bits &= bits - 1) {
          const int l = lowest_bit(bits);
          pack<kind>(k + l, lane(min_distance, l));
        }
      }
      near.drop();
      for (int k = 0; k < kPairBlock; ++k) distance_of[k] = distance_of[kPairBlock + k];
    }

    template <PairKind kind>
    KERNEL void pack(int k, R min_distance) {
      const int i[4] = {near.particles[0][k], near.particles[1][k], near.particles[2][k], near.particles[3][k]};
      if (!query.template leaves_out<kind>(i)) builder.add(i, min_distance);
    }
  };
};

}  // namespace malha
