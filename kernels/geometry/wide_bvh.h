// SPDX-License-Identifier: Apache-2.0
// Bounding volume hierarchy with 16 children a node, whose boxes one comparison tests. Its topology is fixed; only its
// boxes are refitted.
#pragma once
#include "kernels/geometry/simplex.h"
#include "kernels/simd/rows.h"

namespace malha {

/// Children of a node, and items of a leaf: as many as one comparison tests.
inline constexpr int kBranch = 16;

/// Boxes in structure-of-arrays layout, one array for each bound.
template <class R>
struct BoxRows {
  R* bound[6];  // low x, y, z, high x, y, z
  KERNEL void set(int at, const Box<R>& b) const {
    bound[0][at] = b.low.x, bound[1][at] = b.low.y, bound[2][at] = b.low.z;
    bound[3][at] = b.high.x, bound[4][at] = b.high.y, bound[5][at] = b.high.z;
  }
  KERNEL Box<R> operator[](int at) const {
    return {{bound[0][at], bound[1][at], bound[2][at], R(0)}, {bound[3][at], bound[4][at], bound[5][at], R(0)}};
  }
};

template <class R>
KERNEL Box<R> empty_box() {
  const R far = R(INFINITY);
  return {{far, far, far, R(0)}, {-far, -far, -far, R(0)}};
}

/// Mask of the boxes at .. at + count - 1 that overlap b; count <= kBranch. Reads kBranch boxes.
template <class Isa, class R>
KERNEL unsigned overlaps(const BoxRows<R>& rows, int at, int count, const Box<R>& b) {
  using S = Lane<R, Isa>;
  constexpr int lanes = kLanes<R, Isa>;
  const R own[6] = {b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z};
  unsigned bits = 0;
  for (int k = 0; k < kBranch; k += lanes) {
    const auto overlaps_on = [&](int axis) KERNEL_LAMBDA {
      S low, high;
      load(rows.bound[axis] + at + k, low), load(rows.bound[3 + axis] + at + k, high);
      return (low <= S(own[3 + axis])) & (S(own[axis]) <= high);
    };
    bits |= movemask(overlaps_on(0) & overlaps_on(1) & overlaps_on(2)) << k;
  }
  return count < kBranch ? bits & ((1u << count) - 1) : bits;
}

/// The tree over a list of items, level by level, up to a level of at most kBranch nodes.
template <class R>
struct WideBvh {
  static constexpr int kMaxLevels = 9;
  BoxRows<R> node;                // of the items first, padded with empty boxes up to a multiple of kBranch
  int level[kMaxLevels + 1];      // first node of each level, multiples of kBranch
  int nodes[kMaxLevels], levels;  // number of nodes of each level
};

/// Lays out the levels of a tree over `items`.
template <class R>
KERNEL void lay_out_levels(int items, WideBvh<R>& tree) {
  tree.level[0] = 0, tree.nodes[0] = items, tree.levels = 1;
  for (; tree.nodes[tree.levels - 1] > kBranch; ++tree.levels) {
    const int blocks = (tree.nodes[tree.levels - 1] + kBranch - 1) / kBranch;
    tree.level[tree.levels] = tree.level[tree.levels - 1] + blocks * kBranch;
    tree.nodes[tree.levels] = blocks;
  }
}

/// Boxes that the memory of all levels needs, with those that a comparison reads beyond the last.
template <class R>
KERNEL int node_capacity(const WideBvh<R>& tree) {
  return tree.level[tree.levels - 1] + 2 * kBranch;
}

/// Refits the boxes of a level, each around kBranch nodes of the level below.
template <class R>
struct RefitLevel {
  WideBvh<R> tree;
  int level;
  KERNEL void operator()(int k) const {
    const int first = k * kBranch, below = tree.nodes[level - 1];
    Box<R> box = empty_box<R>();
    for (int i = first; i < first + kBranch && i < below; ++i) box = merge(box, tree.node[tree.level[level - 1] + i]);
    tree.node.set(tree.level[level] + k, box);
  }
};

/// Calls found(i) for every item i whose box overlaps b.
template <class Isa, class R, class Found>
KERNEL void for_each_overlap(const WideBvh<R>& tree, const Box<R>& b, const Found& found) {
  int first[WideBvh<R>::kMaxLevels];
  unsigned bits[WideBvh<R>::kMaxLevels];
  const auto test_children = [&](int level, int at) KERNEL_LAMBDA {
    first[level] = at;
    bits[level] = overlaps<Isa>(tree.node, tree.level[level] + at,
                                tree.nodes[level] - at < kBranch ? tree.nodes[level] - at : kBranch, b);
  };
  int level = tree.levels - 1;
  test_children(level, 0);
  for (;;) {
    if (bits[level] == 0) {
      if (++level == tree.levels) return;
      continue;
    }
    const int node = first[level] + lowest_bit(bits[level]);
    bits[level] &= bits[level] - 1;
    if (level == 0)
      found(node);
    else
      test_children(--level, node * kBranch);
  }
}

}  // namespace malha
