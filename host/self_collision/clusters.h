// SPDX-License-Identifier: Apache-2.0
// Plan of the clusters (kernels/self_collision/cluster_bvh.h): built once, from the positions at the start.
#pragma once
#include <vector>

#include "host/model/self_surface.h"
#include "kernels/self_collision/cluster_bvh.h"

namespace malha {

/// Particles by the solver's numbers; the items of a cluster start at a multiple of kBranch and are padded with -1.
struct ClusterPlan {
  int clusters = 0;
  std::vector<int> begin[kItemKinds];  // first item of each cluster, one more at the end
  std::vector<int> point, corner[3], end[2];
  std::vector<unsigned char> wire_edge;  // of each edge: 1 if it belongs to no triangle
};

/// `x`: positions at the start, m.
ClusterPlan plan_clusters(const SelfSurface& surface, const std::vector<Vec3>& x);

}  // namespace malha
