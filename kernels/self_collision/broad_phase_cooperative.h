// SPDX-License-Identifier: Apache-2.0
// The pairs that kernels/self_collision/broad_phase.h finds, in the same order, where the threads of a block search
// together.
#pragma once
#include "kernels/self_collision/broad_phase.h"

namespace malha {

KERNEL int count_bits(unsigned bits) {
#if defined(__CUDA_ARCH__)
  return __popc(bits);
#else
  return __builtin_popcount(bits);
#endif
}

/// A block a unit: the threads share what there is to compare, and one of them gives places.
template <class R>
struct FindPairsTogether {
  using Shared = void;
  static constexpr int kMostThreads = 32;
  BroadPhaseQuery<R> of;
  HashIndexMap places;

 private:
  static constexpr int kWords = 32;   // of bits: pairs of leaves that are compared at once
  static constexpr int kLeaves = 32;  // pairs of leaves whose items are
  static constexpr int kBatch = 128;  // pairs of items
  static constexpr R kFar = R(-1), kNone = R(-2);
  struct SharedMemory {
    unsigned overlap[kWords];                          // a bit for each pair of leaves
    unsigned short overlaps[kLeaves][kBranch];         // of each item of a leaf, a bit for each of the other
    int one[kLeaves], other[kLeaves], count[kLeaves];  // the first items of these leaves; how many of those bits
    int i[4][kBatch];                                  // particles of pairs
    R min_distance[kBatch];                            // below 0: kFar, or no pair at all
    ContactBlockBuilder<R, HashIndexMap::Places> placed;
  };
  /// Of each unit u with v: which items of which unit, and the pairs of their leaves.
  struct Leaves {
    int one, other, of_one, of_other;  // the first leaves, and how many
    bool alike;                        // the same items: pairs once
    KERNEL int all() const { return of_one * of_other; }
  };

 public:
  static constexpr size_t kBytes = sizeof(SharedMemory);  // of fast memory

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    SharedMemory& bench = *static_cast<SharedMemory*>(group.memory);
    const HashIndexMap::Places own = places.of(of.pairs.patches[group.index], of.pairs.touched);
    group.for_each(own.mask + 1, [&](int k) KERNEL_LAMBDA { own.table[k] = 0; });
    group.for_each(1, [&](int) KERNEL_LAMBDA { bench.placed.start(of.pairs, group.index, own); });
    find<PairKind::Face>(group, bench, 0, false);
    find<PairKind::Edges>(group, bench, 1, false);
    if (of.has_bare) find<PairKind::Edges>(group, bench, 2, true);
    group.for_each(1, [&](int) KERNEL_LAMBDA { bench.placed.finish(group.index); });
  }

 private:
  template <PairKind kind, class Group>
  KERNEL void find(const Group& group, SharedMemory& bench, int section, bool wire_edge) const {
    const int u = group.index;
    for_each_overlapping_cluster<OneLane>(of.units, u, [&](int v) KERNEL_LAMBDA {
      if (!of.owns(u, v)) return;
      const int turns = kind == PairKind::Face && v != u ? 2 : 1;
      for (int turn = 0; turn < turns; ++turn)
        meet<kind>(group, bench, turn == 0 ? u : v, turn == 0 ? v : u, wire_edge);
    });
    group.for_each(1, [&](int) KERNEL_LAMBDA { bench.placed.end_section(section); });
  }

  template <PairKind kind, class Group>
  KERNEL_NOINLINE void meet(const Group& group, SharedMemory& bench, int one, int other, bool wire_edge) const {
    constexpr UnitItems kOne = kOneSide<kind>, kOther = kOtherSide<kind>;
    const auto leaf = [&](UnitItems items, int unit) KERNEL_LAMBDA { return of.units.begin[items][unit] / kBranch; };
    const Leaves leaves{leaf(kOne, one), leaf(kOther, other), leaf(kOne, one + 1) - leaf(kOne, one),
                        leaf(kOther, other + 1) - leaf(kOther, other), one == other && kOne == kOther};
    const auto add = [](int& sum, int value) KERNEL_LAMBDA { sum += value; };
    for (int begin = 0; begin < leaves.all(); begin += 32 * kWords) {
      const int some = min(leaves.all() - begin, 32 * kWords), stretch = (some + kWords - 1) / kWords;
      const int overlapping = group.reduce(
          kWords, 0,
          [&](int word) KERNEL_LAMBDA {
            return compare_leaves<kind>(bench, leaves, begin + word * stretch, min(stretch, some - word * stretch),
                                        word);
          },
          add);
      for (int first = 0; first < overlapping; first += kLeaves) {
        const int few = min(kLeaves, overlapping - first);
        const int candidates = group.reduce(
            few, 0,
            [&](int k) KERNEL_LAMBDA { return compare_items<kind>(bench, leaves, begin, stretch, first + k, k); }, add);
        for (int c = 0; c < candidates; c += kBatch) {
          const int batch = min(kBatch, candidates - c);
          group.for_each(batch, [&](int k) KERNEL_LAMBDA { look<kind>(bench, c + k, k, wire_edge); });
          group.for_each(1, [&](int) KERNEL_LAMBDA { place(bench, batch); });
        }
      }
    }
  }

  /// `count` pairs of leaves from `first` on, which may be none.
  template <PairKind kind>
  KERNEL int compare_leaves(SharedMemory& bench, const Leaves& leaves, int first, int count, int word) const {
    unsigned bits = 0;
    for (int k = 0; k < count; ++k) {
      const int a = (first + k) / leaves.of_other, b = (first + k) % leaves.of_other;
      if (leaves.alike && b < a) continue;
      const Box<R> one = of.units.leaf[kOneSide<kind>][leaves.one + a];
      bits |= unsigned(overlap(one, of.units.leaf[kOtherSide<kind>][leaves.other + b])) << k;
    }
    bench.overlap[word] = bits;
    return count_bits(bits);
  }

  /// The items of the pair of leaves that is the `which`th to overlap.
  template <PairKind kind>
  KERNEL int compare_items(SharedMemory& bench, const Leaves& leaves, int begin, int stretch, int which, int to) const {
    int word = 0;
    for (int bits; which >= (bits = count_bits(bench.overlap[word])); ++word) which -= bits;
    const int pair = begin + word * stretch + bit_at(bench.overlap[word], which);
    const int one = kBranch * (leaves.one + pair / leaves.of_other);
    const int other = kBranch * (leaves.other + pair % leaves.of_other);
    int count = 0;
    for (int k = 0; k < kBranch; ++k) {
      const Box<R> box = of.units.item[kOneSide<kind>][one + k];
      unsigned bits = overlaps<OneLane>(of.units.item[kOtherSide<kind>], other, kBranch, box);
      if (leaves.alike && one == other) bits &= ~((2u << k) - 1);
      bench.overlaps[to][k] = static_cast<unsigned short>(bits);
      count += count_bits(bits);
    }
    bench.one[to] = one, bench.other[to] = other, bench.count[to] = count;
    return count;
  }

  /// The `which`th of the pairs of items that overlap: whether it is a pair, and near enough.
  template <PairKind kind>
  KERNEL void look(SharedMemory& bench, int which, int to, bool wire_edge) const {
    int leaf = 0, item = 0;
    for (; which >= bench.count[leaf]; ++leaf) which -= bench.count[leaf];
    const unsigned short* const bits = bench.overlaps[leaf];
    for (int count; which >= (count = count_bits(bits[item])); ++item) which -= count;
    int c[4];
    R found = kNone;
    if (of.template particles<kind>(bench.one[leaf] + item, bench.other[leaf] + bit_at(bits[item], which), wire_edge,
                                    c)) {
      const PairIndices at{{c, c + 1, c + 2, c + 3}};
      const R least = min_swept_distance<kind, R>(of.reach, at);
      const R min_distance = required_distance<kind, R>(of.reach, of.thickness, at);
      const bool parts = of.crosses != nullptr && cross_at_both_sides<kind>(of.reach, of.crosses, c);
      found = least <= of.thickness && least <= min_distance && !parts ? min_distance : kFar;
    }
    for (int j = 0; j < 4; ++j) bench.i[j][to] = c[j];
    bench.min_distance[to] = found;
  }

  KERNEL static void place(SharedMemory& bench, int batch) {
    for (int k = 0; k < batch; ++k) {
      const R min_distance = bench.min_distance[k];
      bench.placed.patch.candidates += min_distance >= kFar;
      if (!(min_distance >= R(0))) continue;
      const int i[4] = {bench.i[0][k], bench.i[1][k], bench.i[2][k], bench.i[3][k]};
      bench.placed.add(i, min_distance);
    }
  }

  /// Where the `which`th bit is.
  KERNEL static int bit_at(unsigned bits, int which) {
    for (; which > 0; --which) bits &= bits - 1;
    return lowest_bit(bits);
  }
};

}  // namespace malha
