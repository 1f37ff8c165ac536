// SPDX-License-Identifier: Apache-2.0
// Clusters and their bounding volume hierarchy. A cluster is about a hundred particles that are close together at the
// start, with the triangles and edges that belong to them. The topology of the tree is fixed; only its boxes are
// refitted.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/geometry/wide_bvh.h"

namespace malha {

/// Kinds of items of a cluster.
enum ClusterItems { kPoints, kTriangles, kEdges, kItemKinds };

/// Items of each kind, cluster by cluster; those of a cluster start at a multiple of kBranch and are padded with empty
/// items (particle < 0). Particle indices are multiplied by kIndexScale.
template <class R>
struct ClusterBvh {
  int count, has_wire_edges;     // clusters; whether any edge belongs to no triangle
  const int* begin[kItemKinds];  // first item of each cluster, one more at the end
  const int* point;
  const int* corner[3];
  const int* end[2];
  const unsigned char* wire_edge;  // of each edge: 1 if it belongs to no triangle
  BoxRows<R> item[kItemKinds], leaf[kItemKinds];
  WideBvh<R> tree;  // over the clusters
};

/// Refits the boxes of a cluster: its items, its leaves, and its own.
template <class R>
struct RefitLeaves {
  ClusterBvh<R> clusters;
  const Box<R>* particles;
  KERNEL void operator()(int u) const {
    Box<R> whole_box = empty_box<R>();
    for (int kind = 0; kind < kItemKinds; ++kind)
      for (int first = clusters.begin[kind][u]; first < clusters.begin[kind][u + 1]; first += kBranch) {
        Box<R> leaf = empty_box<R>();
        for (int i = first; i < first + kBranch; ++i) {
          const Box<R> box = of_item(kind, i);
          clusters.item[kind].set(i, box);
          leaf = merge(leaf, box);
        }
        clusters.leaf[kind].set(first / kBranch, leaf);
        whole_box = merge(whole_box, leaf);
      }
    clusters.tree.node.set(u, whole_box);
  }

 private:
  KERNEL const Box<R>& of(int scaled) const { return particles[scaled / kIndexScale<R>]; }
  KERNEL Box<R> of_item(int kind, int i) const {
    if (kind == kPoints) return clusters.point[i] < 0 ? empty_box<R>() : of(clusters.point[i]);
    if (kind == kEdges)
      return clusters.end[0][i] < 0 ? empty_box<R>() : merge(of(clusters.end[0][i]), of(clusters.end[1][i]));
    if (clusters.corner[0][i] < 0) return empty_box<R>();
    return merge(merge(of(clusters.corner[0][i]), of(clusters.corner[1][i])), of(clusters.corner[2][i]));
  }
};

/// Calls found(i, first, bits) for the items i of cluster u (of kind of_u) whose boxes overlap those of items first + k
/// of cluster v (of kind of_v), for each bit k. Within one cluster and kind only later items are reported.
template <class Isa, class R, class Found>
KERNEL void for_each_overlapping_pair(const ClusterBvh<R>& clusters, int u, int of_u, int v, int of_v,
                                      const Found& found) {
  const BoxRows<R>&own = clusters.leaf[of_u], &other = clusters.leaf[of_v];
  const Box<R> whole_box = clusters.tree.node[v];
  const int begin = clusters.begin[of_v][v] / kBranch, end = clusters.begin[of_v][v + 1] / kBranch;
  const bool alike = u == v && of_u == of_v;
  for (int a = clusters.begin[of_u][u] / kBranch; a < clusters.begin[of_u][u + 1] / kBranch; ++a) {
    const Box<R> box = own[a];
    if (!overlap(box, whole_box)) continue;
    for (int some = alike ? a : begin; some < end; some += kBranch) {
      unsigned leaves = overlaps<Isa>(other, some, end - some < kBranch ? end - some : kBranch, box);
      for (; leaves != 0; leaves &= leaves - 1) {
        const int b = some + lowest_bit(leaves);
        unsigned own_items = overlaps<Isa>(clusters.item[of_u], a * kBranch, kBranch, other[b]);
        for (; own_items != 0; own_items &= own_items - 1) {
          const int k = lowest_bit(own_items), i = a * kBranch + k;
          unsigned other_items = overlaps<Isa>(clusters.item[of_v], b * kBranch, kBranch, clusters.item[of_u][i]);
          if (alike && a == b) other_items &= ~((2u << k) - 1);
          found(i, b * kBranch, other_items);
        }
      }
    }
  }
}

}  // namespace malha
