// SPDX-License-Identifier: Apache-2.0
#include "host/model/long_range.h"

#include <algorithm>

#include "host/mesh/geodesic.h"
#include "host/mesh/topology.h"

namespace malha {

namespace {

/// The pins of each connected group, or one group of all pins if there are more than kMostPinGroups.
std::vector<std::vector<int>> pin_groups(const std::vector<Edge>& edges, const std::vector<bool>& pinned) {
  std::vector<Edge> between;
  for (const Edge& e : edges)
    if (pinned[e[0]] && pinned[e[1]]) between.push_back(e);
  const int n = static_cast<int>(pinned.size());
  int parts = 0;
  const std::vector<int> part = components(n, between, parts);
  std::vector<int> group_of(parts, -1);
  std::vector<std::vector<int>> groups;
  std::vector<int> all;
  for (int i = 0; i < n; ++i) {
    if (!pinned[i]) continue;
    all.push_back(i);
    int& group = group_of[part[i]];
    if (group < 0) group = static_cast<int>(groups.size()), groups.emplace_back();
    groups[group].push_back(i);
  }
  if (static_cast<int>(groups.size()) > kMostPinGroups) groups = {all};
  return groups;
}

}  // namespace

void attach_long_range(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<bool>& pinned, double limit,
                       const std::vector<int>& solver_index, LongRangeSet& set) {
  std::vector<Geodesics> of_groups;
  for (const std::vector<int>& group : pin_groups(edges, pinned)) of_groups.push_back(geodesics(mesh, group));
  if (set.begin.empty()) set.begin = {0};
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (pinned[i]) continue;
    std::vector<std::pair<double, int>> found;
    for (const Geodesics& group : of_groups)
      if (group.source[i] >= 0) found.emplace_back(group.distance[i], group.source[i]);
    if (found.empty()) continue;
    std::sort(found.rbegin(), found.rend());
    set.particle.push_back(solver_index[i]);
    for (const auto& [distance, pin] : found)
      set.anchor.push_back(solver_index[pin]), set.max_distance.push_back(distance * (1 + limit));
    set.begin.push_back(static_cast<int>(set.anchor.size()));
  }
}

}  // namespace malha
