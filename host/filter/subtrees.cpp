// SPDX-License-Identifier: Apache-2.0
#include "host/filter/subtrees.h"

#include <algorithm>
#include <cstdint>

namespace malha {

Subtrees subtrees(const Supernodes& all) {
  // A task has at least so many numbers of the factor, which take some microseconds. Each supernode takes as long as
  // `overhead` more numbers.
  constexpr std::int64_t most_tasks = 32, least = 8192, overhead = 100;
  const int count = all.count();
  std::vector<std::int64_t> cost(count);
  std::int64_t total = 0;
  for (int s = 0; s < count; ++s) total += cost[s] = std::int64_t(all.columns(s)) * all.height(s) + overhead;
  for (int s = 0; s < count; ++s)
    if (all.parent[s] >= 0) cost[all.parent[s]] += cost[s];

  Subtrees cut;
  const std::int64_t size = std::max(least, total / most_tasks), piece = total <= least ? total : size / 2;
  std::vector<bool> inside(count, false);  // marks the supernodes that belong to a piece
  for (int s = count - 1; s >= 0; --s) {
    const int up = all.parent[s];
    inside[s] = cost[s] <= piece || (up >= 0 && inside[up]);
  }
  std::int64_t filled = size;  // so that the first piece begins a task
  for (int s = 0, next; s < count; s = next) {
    next = s + 1;
    if (!inside[s]) {
      cut.top.push_back(s);
      continue;
    }
    int root = s;
    while (all.parent[root] >= 0 && inside[all.parent[root]]) root = all.parent[root];
    next = root + 1;  // in postorder a piece is a consecutive run that begins with s
    if (filled + cost[root] > size) cut.tasks.emplace_back(), filled = 0;
    filled += cost[root];
    for (int k = s; k < next; ++k) cut.tasks.back().push_back(k);
  }
  return cut;
}

}  // namespace malha
