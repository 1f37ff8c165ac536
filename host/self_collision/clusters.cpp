// SPDX-License-Identifier: Apache-2.0
#include "host/self_collision/clusters.h"

#include <algorithm>
#include <array>
#include <map>

#include "host/mesh/bisection.h"

namespace malha {

namespace {

constexpr int kClusterParticles = 128, kGroup = 4;

/// Bisects the list into whole clusters, whole leaves, and groups of four, so that the edges and triangles of a leaf
/// are close together too.
void bisect_into_clusters(const std::vector<Vec3>& x, std::vector<int>& list) {
  bisect(x, list, kGroup, [](int count) {
    return count > kClusterParticles ? kClusterParticles : count > kBranch ? kBranch : kGroup;
  });
}

/// All particles with a simplex, in order; large bodies one by one, because bodies separate.
std::vector<int> ordered_points(const SelfSurface& surface, const std::vector<Vec3>& x) {
  std::map<int, std::vector<int>> of_body;
  for (const Simplex& s : surface.simplices)
    for (int k = 0; k < 3; ++k)
      if (s.owns_corner(k)) of_body[surface.body[s.corner[k]]].push_back(s.corner[k]);
  std::vector<int> all, small;
  for (auto& [body, points] : of_body) {
    if (static_cast<int>(points.size()) < kClusterParticles) {
      small.insert(small.end(), points.begin(), points.end());
      continue;
    }
    bisect_into_clusters(x, points);
    all.insert(all.end(), points.begin(), points.end());
  }
  bisect_into_clusters(x, small);
  all.insert(all.end(), small.begin(), small.end());
  return all;
}

/// An item, and the sorted ranks of its particles, which order it among the items.
template <int n>
struct Ranked {
  std::array<int, n> rank, particle;
  bool wire_edge;
  bool operator<(const Ranked& o) const { return rank < o.rank; }
};
template <int n>
Ranked<n> ranked(const std::array<int, n>& particle, const std::vector<int>& rank, bool wire_edge = false) {
  Ranked<n> item{{}, particle, wire_edge};
  for (int k = 0; k < n; ++k) item.rank[k] = rank[particle[k]];
  std::sort(item.rank.begin(), item.rank.end());
  return item;
}

std::array<int, 2> ends_in_order(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Adds the sorted items cluster by cluster, padded to whole leaves. Returns the first item of each cluster.
template <int n, class Add>
std::vector<int> add_by_cluster(const std::vector<Ranked<n>>& items, int clusters, const Add& add) {
  std::vector<int> begin{0};
  std::size_t next = 0;
  for (int u = 0; u < clusters; ++u) {
    int count = begin.back();
    for (; next < items.size() && items[next].rank[0] / kClusterParticles == u; ++next, ++count) add(&items[next]);
    for (; count % kBranch != 0; ++count) add(nullptr);
    begin.push_back(count);
  }
  return begin;
}

}  // namespace

ClusterPlan plan_clusters(const SelfSurface& surface, const std::vector<Vec3>& x) {
  const std::vector<int> points = ordered_points(surface, x);
  std::vector<int> rank(x.size(), -1);
  std::vector<Ranked<1>> of_points;
  for (std::size_t k = 0; k < points.size(); ++k) {
    rank[points[k]] = static_cast<int>(k);
    of_points.push_back({{static_cast<int>(k)}, {points[k]}, false});
  }
  std::vector<Ranked<3>> triangles;
  std::vector<Ranked<2>> edges;
  std::vector<std::array<int, 2>> with_triangle;
  for (const Simplex& s : surface.simplices)
    if (s.is_face()) triangles.push_back(ranked<3>({s.corner[0], s.corner[1], s.corner[2]}, rank));
  for (const Simplex& s : surface.simplices)
    for (int k = 0; k < 3; ++k) {
      if (s.from(k) == s.to(k)) continue;
      if (s.owns_edge(k)) edges.push_back(ranked<2>({s.from(k), s.to(k)}, rank));
      if (s.is_face()) with_triangle.push_back(ends_in_order(s.from(k), s.to(k)));
    }
  std::sort(with_triangle.begin(), with_triangle.end());
  for (auto& edge : edges) {
    const std::array<int, 2> ends = ends_in_order(edge.particle[0], edge.particle[1]);
    edge.wire_edge = !std::binary_search(with_triangle.begin(), with_triangle.end(), ends);
  }
  std::sort(triangles.begin(), triangles.end());
  std::sort(edges.begin(), edges.end());

  ClusterPlan plan;
  plan.clusters = (static_cast<int>(points.size()) + kClusterParticles - 1) / kClusterParticles;
  plan.begin[kPoints] = add_by_cluster(of_points, plan.clusters,
                                       [&](const Ranked<1>* at) { plan.point.push_back(at ? at->particle[0] : -1); });
  plan.begin[kTriangles] = add_by_cluster(triangles, plan.clusters, [&](const Ranked<3>* at) {
    for (int k = 0; k < 3; ++k) plan.corner[k].push_back(at ? at->particle[k] : -1);
  });
  plan.begin[kEdges] = add_by_cluster(edges, plan.clusters, [&](const Ranked<2>* at) {
    for (int k = 0; k < 2; ++k) plan.end[k].push_back(at ? at->particle[k] : -1);
    plan.wire_edge.push_back(at && at->wire_edge);
  });
  return plan;
}

}  // namespace malha
