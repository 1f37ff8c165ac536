// SPDX-License-Identifier: Apache-2.0
// Which particles, triangles and edges search for pairs together: planned once, from where they are at the start.
#pragma once
#include <vector>

#include "host/model/self_surface.h"
#include "kernels/self_collision/cluster_bvh.h"

namespace malha {

/// Solver's numbers; each unit's items of a kind from a multiple of kBranch on, padded with -1.
struct ClusterPlan {
  int units = 0;
  std::vector<int> begin[kItemKinds];  // of each unit's items, and one more
  std::vector<int> point, corner[3], end[2];
  std::vector<unsigned char> wire_edge;  // of each edge: whether no triangle has it
  std::vector<int> level, nodes;         // of the tree over the units: where each level begins, and how many it has
};

/// `x`: positions at the start, m.
ClusterPlan plan_clusters(const SelfSurface& surface, const std::vector<Vec3>& x);

}  // namespace malha
