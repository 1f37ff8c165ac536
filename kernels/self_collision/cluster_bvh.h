// SPDX-License-Identifier: Apache-2.0
// Clusters and their bounding volume hierarchy. A cluster is some hundred particles that lie together at the start,
// with the triangles and edges that belong to them, and a tree of boxes over all. The tree stays as it is; only its
// boxes are made anew.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/geometry/simplex.h"

namespace malha {

/// Children of a node, and items of a leaf: as many as a comparison takes.
inline constexpr int kBranch = 16;

/// Boxes side by side, one array a bound.
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

/// Of the boxes at .. at + count - 1, at most kBranch, those that overlap b: a bit each. Reads kBranch of them.
template <class Isa, class R>
KERNEL unsigned overlaps(const BoxRows<R>& rows, int at, int count, const Box<R>& b) {
  using S = Lane<R, Isa>;
  constexpr int lanes = kLanes<R, Isa>;
  const R own[6] = {b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z};
  unsigned bits = 0;
  for (int k = 0; k < kBranch; k += lanes) {
    const auto meets = [&](int axis) KERNEL_LAMBDA {
      S low, high;
      load(rows.bound[axis] + at + k, low), load(rows.bound[3 + axis] + at + k, high);
      return (low <= S(own[3 + axis])) & (S(own[axis]) <= high);
    };
    bits |= movemask(meets(0) & meets(1) & meets(2)) << k;
  }
  return count < kBranch ? bits & ((1u << count) - 1) : bits;
}

/// Of what may meet.
enum UnitItems { kPoints, kTriangles, kEdges, kItemKinds };

/// Items of each kind, unit by unit, each unit's from a multiple of kBranch on, padded with items that are nowhere
/// (particle < 0). Particles are numbered times kIndexScale.
template <class R>
struct ClusterBvh {
  static constexpr int kMaxLevels = 9;
  int count;
  const int* begin[kItemKinds];  // of each unit's items, and one more
  const int* point;
  const int* corner[3];
  const int* end[2];
  const unsigned char* wire_edge;  // of each edge: whether no triangle has it
  BoxRows<R> item[kItemKinds], leaf[kItemKinds];
  BoxRows<R> node;                // units first, then what lies over each kBranch, up to no more than kBranch
  int level[kMaxLevels + 1];      // where each level of nodes begins, by multiples of kBranch
  int nodes[kMaxLevels], levels;  // of each level
};

/// Boxes of a unit's items, leaves, and its own.
template <class R>
struct RefitLeaves {
  ClusterBvh<R> units;
  const Box<R>* particles;
  KERNEL void operator()(int u) const {
    Box<R> whole = empty_box<R>();
    for (int kind = 0; kind < kItemKinds; ++kind)
      for (int first = units.begin[kind][u]; first < units.begin[kind][u + 1]; first += kBranch) {
        Box<R> leaf = empty_box<R>();
        for (int i = first; i < first + kBranch; ++i) {
          const Box<R> box = of_item(kind, i);
          units.item[kind].set(i, box);
          leaf = merge(leaf, box);
        }
        units.leaf[kind].set(first / kBranch, leaf);
        whole = merge(whole, leaf);
      }
    units.node.set(u, whole);
  }

 private:
  KERNEL const Box<R>& of(int scaled) const { return particles[scaled / kIndexScale<R>]; }
  KERNEL Box<R> of_item(int kind, int i) const {
    if (kind == kPoints) return units.point[i] < 0 ? empty_box<R>() : of(units.point[i]);
    if (kind == kEdges) return units.end[0][i] < 0 ? empty_box<R>() : merge(of(units.end[0][i]), of(units.end[1][i]));
    if (units.corner[0][i] < 0) return empty_box<R>();
    return merge(merge(of(units.corner[0][i]), of(units.corner[1][i])), of(units.corner[2][i]));
  }
};

/// The boxes of a level, each around kBranch of the level below.
template <class R>
struct RefitLevel {
  ClusterBvh<R> units;
  int level;
  KERNEL void operator()(int k) const {
    const int first = k * kBranch, below = units.nodes[level - 1];
    Box<R> box = empty_box<R>();
    for (int i = first; i < first + kBranch && i < below; ++i) box = merge(box, units.node[units.level[level - 1] + i]);
    units.node.set(units.level[level] + k, box);
  }
};

/// Calls found(v) for every unit that may meet unit u.
template <class Isa, class R, class Found>
KERNEL void for_each_overlapping_cluster(const ClusterBvh<R>& units, int u, const Found& found) {
  const Box<R> b = units.node[u];
  int first[ClusterBvh<R>::kMaxLevels];
  unsigned bits[ClusterBvh<R>::kMaxLevels];
  const auto look = [&](int level, int at) KERNEL_LAMBDA {
    first[level] = at;
    bits[level] = overlaps<Isa>(units.node, units.level[level] + at,
                                units.nodes[level] - at < kBranch ? units.nodes[level] - at : kBranch, b);
  };
  int level = units.levels - 1;
  look(level, 0);
  for (;;) {
    if (bits[level] == 0) {
      if (++level == units.levels) return;
      continue;
    }
    const int node = first[level] + lowest_bit(bits[level]);
    bits[level] &= bits[level] - 1;
    if (level == 0)
      found(node);
    else
      look(--level, node * kBranch);
  }
}

/// Calls found(i, first, bits) for the items i of unit u and those of unit v, of these kinds, that may meet: items
/// first + k for each bit k. Of a kind with itself in one unit, only later ones.
template <class Isa, class R, class Found>
KERNEL void for_each_overlapping_pair(const ClusterBvh<R>& units, int u, int of_u, int v, int of_v,
                                      const Found& found) {
  const BoxRows<R>&own = units.leaf[of_u], &other = units.leaf[of_v];
  const Box<R> whole = units.node[v];
  const int begin = units.begin[of_v][v] / kBranch, end = units.begin[of_v][v + 1] / kBranch;
  const bool alike = u == v && of_u == of_v;
  for (int a = units.begin[of_u][u] / kBranch; a < units.begin[of_u][u + 1] / kBranch; ++a) {
    const Box<R> box = own[a];
    if (!overlap(box, whole)) continue;
    for (int some = alike ? a : begin; some < end; some += kBranch) {
      unsigned leaves = overlaps<Isa>(other, some, end - some < kBranch ? end - some : kBranch, box);
      for (; leaves != 0; leaves &= leaves - 1) {
        const int b = some + lowest_bit(leaves);
        unsigned mine = overlaps<Isa>(units.item[of_u], a * kBranch, kBranch, other[b]);
        for (; mine != 0; mine &= mine - 1) {
          const int k = lowest_bit(mine), i = a * kBranch + k;
          unsigned theirs = overlaps<Isa>(units.item[of_v], b * kBranch, kBranch, units.item[of_u][i]);
          if (alike && a == b) theirs &= ~((2u << k) - 1);
          found(i, b * kBranch, theirs);
        }
      }
    }
  }
}

}  // namespace malha
