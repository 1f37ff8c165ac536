// SPDX-License-Identifier: Apache-2.0
#include "host/filter/supernodes.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "host/filter/elimination_order.h"
#include "host/mesh/compressed_lists.h"
#include "host/model/ordering/index_map.h"

namespace malha {

namespace {

/// The other entries of the system, its rows and columns in another order.
struct Pattern {
  std::vector<int> begin, column;
  Pattern(const SpringSystem& system, const std::vector<int>& order) : begin{0} {
    const std::vector<int> now = solver_of(order);
    column.reserve(system.column.size());
    for (const int i : order) {
      for (int k = system.begin[i]; k < system.begin[i + 1]; ++k) column.push_back(now[system.column[k]]);
      begin.push_back(static_cast<int>(column.size()));
    }
  }
  template <class Visit>
  void each(int j, const Visit& visit) const {
    for (int k = begin[j]; k < begin[j + 1]; ++k) visit(column[k]);
  }
  int count() const { return static_cast<int>(begin.size()) - 1; }
};

/// Finds the parent of each column in the elimination tree (Liu 1986, with path compression).
std::vector<int> elimination_tree(const Pattern& pattern) {
  std::vector<int> parent(pattern.count(), -1), ancestor(pattern.count(), -1);
  for (int j = 0; j < pattern.count(); ++j)
    pattern.each(j, [&](int i) {
      while (i >= 0 && i < j) {
        const int next = ancestor[i];
        ancestor[i] = j;
        if (next < 0) parent[i] = j;
        i = next;
      }
    });
  return parent;
}

/// Lists children before parents and each subtree in one piece. A parent's largest subtree comes last, so that its
/// columns adjoin the parent's.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> size(n, 1), order, stack;
  for (int j = 0; j < n; ++j)
    if (parent[j] >= 0) size[parent[j]] += size[j];
  CompressedLists<int> children(n + 1, [&](const auto& add) {  // list n has the roots
    for (int j = 0; j < n; ++j) add(parent[j] < 0 ? n : parent[j], j);
  });
  for (int j = 0; j <= n; ++j) std::ranges::stable_sort(children[j], [&](int a, int b) { return size[a] < size[b]; });
  // The order is a preorder with the largest child first, reversed.
  const auto push_children = [&](int j) { stack.insert(stack.end(), children[j].begin(), children[j].end()); };
  push_children(n);
  while (!stack.empty()) {
    const int j = stack.back();
    stack.pop_back();
    order.push_back(j);
    push_children(j);
  }
  std::ranges::reverse(order);
  return order;
}

/// Counts the numbers of each column of the factor, with the diagonal. Row i of the factor has the columns on the paths
/// from those of the matrix up to i in the elimination tree.
std::vector<int> column_counts(const Pattern& pattern, const std::vector<int>& parent) {
  std::vector<int> count(pattern.count(), 1), row(pattern.count(), -1);
  for (int i = 0; i < pattern.count(); ++i) {
    row[i] = i;
    pattern.each(i, [&](int j) {
      for (; j < i && row[j] != i; j = parent[j]) row[j] = i, ++count[j];
    });
  }
  return count;
}

/// Returns the first column of each supernode, and the number of columns as the last entry.
std::vector<int> fundamental(const std::vector<int>& parent, const std::vector<int>& count) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> children(n, 0), begin;
  for (int j = 0; j < n; ++j)
    if (parent[j] >= 0) ++children[parent[j]];
  for (int j = 0; j < n; ++j)
    if (j == 0 || parent[j - 1] != j || count[j - 1] != count[j] + 1 || children[j] > 1) begin.push_back(j);
  begin.push_back(n);
  return begin;
}

/// Tells whether to merge two supernodes into one of `columns` of whose entries this share would be zeros.
bool should_merge(double columns, double zeros) {
  return zeros == 0 || columns <= 4 || (columns <= 16 && zeros < 0.8) || (columns <= 48 && zeros < 0.1) || zeros < 0.05;
}

/// Merges supernodes with the one that follows, if that is their parent and the zeros are few.
std::vector<int> amalgamate(const std::vector<int>& begin, const std::vector<int>& parent,
                            const std::vector<int>& count) {
  const int supernodes = static_cast<int>(begin.size()) - 1;
  std::vector<int> height(supernodes), end(supernodes);
  std::vector<double> zeros(supernodes, 0);
  std::vector<bool> merged(supernodes + 1, false);  // tells whether a supernode is merged with the one before it
  for (int s = supernodes - 1; s >= 0; --s) {
    height[s] = count[begin[s]], end[s] = begin[s + 1];
    const int up = parent[begin[s + 1] - 1];
    if (s + 1 == supernodes || up < 0 || up >= end[s + 1]) continue;
    const double own = begin[s + 1] - begin[s], columns = end[s + 1] - begin[s], tall = own + height[s + 1];
    const double all_zeros = zeros[s + 1] + own * (tall - height[s]);
    const double size = columns * (columns + 1) / 2 + columns * (tall - columns);
    if (!should_merge(columns, all_zeros / size)) continue;
    merged[s + 1] = true;
    end[s] = end[s + 1], height[s] = static_cast<int>(tall), zeros[s] = all_zeros;
  }
  std::vector<int> kept;
  for (int s = 0; s <= supernodes; ++s)
    if (!merged[s]) kept.push_back(begin[s]);
  return kept;
}

/// Finds the rows below each supernode: those of its columns in the matrix, and those of its children.
void find_rows(const Pattern& pattern, const std::vector<int>& parent, Supernodes& all) {
  const int supernodes = static_cast<int>(all.column_begin.size()) - 1;
  std::vector<int> holder(pattern.count()), seen(pattern.count(), -1), child(supernodes, -1), sibling(supernodes, -1);
  for (int s = 0; s < supernodes; ++s)
    for (int j = all.column_begin[s]; j < all.column_begin[s + 1]; ++j) holder[j] = s;
  all.parent.assign(supernodes, -1);
  all.row_begin = {0};
  for (int s = 0; s < supernodes; ++s) {
    const int first = all.column_begin[s], end = all.column_begin[s + 1];
    std::vector<int> rows;
    const auto add = [&](int i) {
      if (i >= end && seen[i] != s) seen[i] = s, rows.push_back(i);
    };
    for (int j = first; j < end; ++j) pattern.each(j, add);
    for (int c = child[s]; c >= 0; c = sibling[c])
      std::for_each(all.rows.begin() + all.row_begin[c], all.rows.begin() + all.row_begin[c + 1], add);
    std::ranges::sort(rows);
    all.rows.insert(all.rows.end(), rows.begin(), rows.end());
    all.row_begin.push_back(static_cast<int>(all.rows.size()));
    if (const int up = parent[end - 1]; up >= 0) {
      all.parent[s] = holder[up];
      sibling[s] = child[holder[up]], child[holder[up]] = s;
    }
  }
}

}  // namespace

std::int64_t Supernodes::entries() const {
  std::int64_t sum = 0;
  for (int s = 0; s < count(); ++s) sum += std::int64_t(columns(s)) * height(s);
  return sum;
}

Supernodes supernodes(const SpringSystem& system) { return supernodes(system, elimination_order(system)); }

Supernodes supernodes(const SpringSystem& system, const std::vector<int>& elimination_order) {
  Supernodes all;
  for (const int j : postorder(elimination_tree(Pattern(system, elimination_order))))
    all.order.push_back(elimination_order[j]);
  const Pattern pattern(system, all.order);
  const std::vector<int> parent = elimination_tree(pattern), count = column_counts(pattern, parent);
  all.column_begin = amalgamate(fundamental(parent, count), parent, count);
  find_rows(pattern, parent, all);
  return all;
}

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
