// SPDX-License-Identifier: Apache-2.0
// Broad phase of self-collision for a device: finds the pairs of kernels/self_collision/broad_phase.h in the same
// order, with the threads of a block cooperating on a cluster.
#pragma once
#include "kernels/self_collision/broad_phase.h"

namespace malha {

/// Finds the pairs that a cluster owns with one block of threads: the threads share the comparisons, and one of them
/// packs the pairs.
template <class R>
struct FindCandidatesCooperatively {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  BroadPhaseQuery<R> query;
  HashIndexMap index_map;

 private:
  static constexpr int kMaskWords = 32;  // of bits: pairs of leaves that are compared at once
  static constexpr int kLeaves = 32;     // pairs of leaves whose items are compared at once
  static constexpr int kBatch = 128;     // pairs of items that are tested at once
  static constexpr R kFar = R(-1), kNone = R(-2);
  struct SharedMemory {
    unsigned overlap[kMaskWords];                      // a bit for each pair of leaves
    unsigned short overlaps[kLeaves][kBranch];         // for each item of a leaf, a bit for each item of the other
    int one[kLeaves], other[kLeaves], count[kLeaves];  // the first items of these leaves; number of those bits
    int i[4][kBatch];                                  // particles of pairs
    R min_distance[kBatch];                            // kFar: too far apart; kNone: no pair
    ContactBlockBuilder<R, HashIndexMap::Map> builder;
  };
  /// The leaves of two clusters whose pairs are compared.
  struct Leaves {
    int one, other, one_count, other_count;  // the first leaves, and their numbers
    bool alike;                              // the same items: each pair once
    KERNEL int all() const { return one_count * other_count; }
  };

 public:
  static constexpr size_t kBytes = sizeof(SharedMemory);  // of shared memory

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    SharedMemory& shared = *static_cast<SharedMemory*>(group.memory);
    const HashIndexMap::Map map = index_map.of(query.pairs.patches[group.index], query.pairs.patch_particles);
    group.for_each(map.mask + 1, [&](int k) KERNEL_LAMBDA { map.table[k] = 0; });
    group.for_each(1, [&](int) KERNEL_LAMBDA { shared.builder.start(query.pairs, group.index, map); });
    find<PairKind::Face>(group, shared, 0, false);
    find<PairKind::Edges>(group, shared, 1, false);
    if (query.clusters.has_wire_edges) find<PairKind::Edges>(group, shared, 2, true);
    group.for_each(1, [&](int) KERNEL_LAMBDA { shared.builder.finish(group.index); });
  }

 private:
  template <PairKind kind, class Group>
  KERNEL void find(const Group& group, SharedMemory& shared, int section, bool wire_edge) const {
    const int u = group.index;
    for_each_overlap<OneLane>(query.clusters.tree, query.clusters.tree.node[u], [&](int v) KERNEL_LAMBDA {
      if (!query.owns(u, v)) return;
      const int passes = kind == PairKind::Face && v != u ? 2 : 1;
      for (int pass = 0; pass < passes; ++pass)
        compare_clusters<kind>(group, shared, pass == 0 ? u : v, pass == 0 ? v : u, wire_edge);
    });
    group.for_each(1, [&](int) KERNEL_LAMBDA { shared.builder.end_section(section); });
  }

  template <PairKind kind, class Group>
  KERNEL_NOINLINE void compare_clusters(const Group& group, SharedMemory& shared, int one, int other,
                                        bool wire_edge) const {
    constexpr ClusterItems kOne = kOneSide<kind>, kOther = kOtherSide<kind>;
    const auto leaf = [&](ClusterItems items, int unit)
                          KERNEL_LAMBDA { return query.clusters.begin[items][unit] / kBranch; };
    const Leaves leaves{leaf(kOne, one), leaf(kOther, other), leaf(kOne, one + 1) - leaf(kOne, one),
                        leaf(kOther, other + 1) - leaf(kOther, other), one == other && kOne == kOther};
    const auto add = [](int& sum, int value) KERNEL_LAMBDA { sum += value; };
    for (int begin = 0; begin < leaves.all(); begin += 32 * kMaskWords) {
      const int pairs_of_leaves = min(leaves.all() - begin, 32 * kMaskWords),
                per_word = (pairs_of_leaves + kMaskWords - 1) / kMaskWords;
      const int overlapping = group.reduce(
          kMaskWords, 0,
          [&](int word) KERNEL_LAMBDA {
            return compare_leaves<kind>(shared, leaves, begin + word * per_word,
                                        min(per_word, pairs_of_leaves - word * per_word), word);
          },
          add);
      for (int first = 0; first < overlapping; first += kLeaves) {
        const int overlapping_here = min(kLeaves, overlapping - first);
        const int candidates = group.reduce(
            overlapping_here, 0,
            [&](int k) KERNEL_LAMBDA { return compare_items<kind>(shared, leaves, begin, per_word, first + k, k); },
            add);
        for (int c = 0; c < candidates; c += kBatch) {
          const int batch = min(kBatch, candidates - c);
          group.for_each(batch, [&](int k) KERNEL_LAMBDA { test_pair<kind>(shared, c + k, k, wire_edge); });
          group.for_each(1, [&](int) KERNEL_LAMBDA { pack(shared, batch); });
        }
      }
    }
  }

  /// Compares `count` pairs of leaves from `first` on; count may be 0 or less. Returns how many overlap.
  template <PairKind kind>
  KERNEL int compare_leaves(SharedMemory& shared, const Leaves& leaves, int first, int count, int word) const {
    unsigned bits = 0;
    for (int k = 0; k < count; ++k) {
      const int a = (first + k) / leaves.other_count, b = (first + k) % leaves.other_count;
      if (leaves.alike && b < a) continue;
      const Box<R> one = query.clusters.leaf[kOneSide<kind>][leaves.one + a];
      bits |= unsigned(overlap(one, query.clusters.leaf[kOtherSide<kind>][leaves.other + b])) << k;
    }
    shared.overlap[word] = bits;
    return count_bits(bits);
  }

  /// Compares the items of the `which`th overlapping pair of leaves. Returns how many overlap.
  template <PairKind kind>
  KERNEL int compare_items(SharedMemory& shared, const Leaves& leaves, int begin, int per_word, int which,
                           int to) const {
    int word = 0;
    for (int bits; which >= (bits = count_bits(shared.overlap[word])); ++word) which -= bits;
    const int pair = begin + word * per_word + bit_at(shared.overlap[word], which);
    const int one = kBranch * (leaves.one + pair / leaves.other_count);
    const int other = kBranch * (leaves.other + pair % leaves.other_count);
    int count = 0;
    for (int k = 0; k < kBranch; ++k) {
      const Box<R> box = query.clusters.item[kOneSide<kind>][one + k];
      unsigned bits = overlaps<OneLane>(query.clusters.item[kOtherSide<kind>], other, kBranch, box);
      if (leaves.alike && one == other) bits &= ~((2u << k) - 1);
      shared.overlaps[to][k] = static_cast<unsigned short>(bits);
      count += count_bits(bits);
    }
    shared.one[to] = one, shared.other[to] = other, shared.count[to] = count;
    return count;
  }

  /// Tests the `which`th overlapping pair of items: whether it is a pair, and near enough.
  template <PairKind kind>
  KERNEL void test_pair(SharedMemory& shared, int which, int to, bool wire_edge) const {
    int leaf = 0, item = 0;
    for (; which >= shared.count[leaf]; ++leaf) which -= shared.count[leaf];
    const unsigned short* const bits = shared.overlaps[leaf];
    for (int count; which >= (count = count_bits(bits[item])); ++item) which -= count;
    int c[4];
    R result = kNone;
    if (query.template particles<kind>(shared.one[leaf] + item, shared.other[leaf] + bit_at(bits[item], which),
                                       wire_edge, c)) {
      const PairIndices at{{c, c + 1, c + 2, c + 3}};
      const R distance = min_swept_distance<kind, R>(query.bounds, at);
      const R min_distance = required_distance<kind, R>(query.bounds, query.thickness, at);
      const bool counts =
          distance <= query.thickness && distance <= min_distance && !query.template leaves_out<kind>(c);
      result = counts ? min_distance : kFar;
    }
    for (int j = 0; j < 4; ++j) shared.i[j][to] = c[j];
    shared.min_distance[to] = result;
  }

  KERNEL static void pack(SharedMemory& shared, int batch) {
    for (int k = 0; k < batch; ++k) {
      const R min_distance = shared.min_distance[k];
      shared.builder.patch.candidates += min_distance >= kFar;
      if (!(min_distance >= R(0))) continue;
      const int i[4] = {shared.i[0][k], shared.i[1][k], shared.i[2][k], shared.i[3][k]};
      shared.builder.add(i, min_distance);
    }
  }

  /// Position of the `which`th set bit.
  KERNEL static int bit_at(unsigned bits, int which) {
    for (; which > 0; --which) bits &= bits - 1;
    return lowest_bit(bits);
  }
};

}  // namespace malha
