// SPDX-License-Identifier: Apache-2.0
#include "host/filter/supernodes.h"

#include <algorithm>
#include <numeric>

#include "host/filter/order_elimination.h"

namespace malha {

namespace {

/// The other entries of the system, its rows and columns in another order.
struct Pattern {
  std::vector<int> begin, column;
  Pattern(const SpringSystem& system, const std::vector<int>& order) : begin{0} {
    std::vector<int> now(order.size());
    for (std::size_t j = 0; j < order.size(); ++j) now[order[j]] = static_cast<int>(j);
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
  std::vector<int> size(n, 1), begin(n + 2, 0), child(n), order, stack;
  for (int j = 0; j < n; ++j)
    if (parent[j] >= 0) size[parent[j]] += size[j];
  for (int j = 0; j < n; ++j) ++begin[parent[j] + 2];  // roots are the children of -1
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int> next(begin.begin(), begin.end() - 1);
  for (int j = 0; j < n; ++j) child[next[parent[j] + 1]++] = j;
  for (int j = -1; j < n; ++j)
    std::stable_sort(child.begin() + begin[j + 1], child.begin() + begin[j + 2],
                     [&](int a, int b) { return size[a] < size[b]; });
  // The order is a preorder with the largest child first, reversed.
  for (int k = begin[0]; k < begin[1]; ++k) stack.push_back(child[k]);
  while (!stack.empty()) {
    const int j = stack.back();
    stack.pop_back();
    order.push_back(j);
    for (int k = begin[j + 1]; k < begin[j + 2]; ++k) stack.push_back(child[k]);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// Counts the numbers of each column of the factor, with the diagonal (Gilbert, Ng, Peyton 1994). Columns are in
/// postorder.
std::vector<int> column_counts(const Pattern& pattern, const std::vector<int>& parent) {
  const int n = pattern.count();
  std::vector<int> count(n), first(n, -1), ancestor(n), latest(n, -1), leaf(n, -1);
  for (int k = 0; k < n; ++k) {
    count[k] = first[k] < 0 ? 1 : 0;
    for (int j = k; j >= 0 && first[j] < 0; j = parent[j]) first[j] = k;
  }
  std::iota(ancestor.begin(), ancestor.end(), 0);
  for (int j = 0; j < n; ++j) {
    if (parent[j] >= 0) --count[parent[j]];
    pattern.each(j, [&](int i) {
      if (i <= j || first[j] <= latest[i]) return;  // j is no leaf of row i's subtree
      latest[i] = first[j];
      const int before = leaf[i];
      leaf[i] = j;
      ++count[j];
      if (before < 0) return;
      int top = before;
      while (top != ancestor[top]) top = ancestor[top];
      for (int k = before, up; k != top; k = up) up = ancestor[k], ancestor[k] = top;
      --count[top];
    });
    if (parent[j] >= 0) ancestor[j] = parent[j];
  }
  for (int j = 0; j < n; ++j)
    if (parent[j] >= 0) count[parent[j]] += count[j];
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
    std::sort(rows.begin(), rows.end());
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

Supernodes supernodes(const SpringSystem& system) {
  Supernodes all;
  const std::vector<int> dissected = elimination_order(system);
  for (const int j : postorder(elimination_tree(Pattern(system, dissected)))) all.order.push_back(dissected[j]);
  const Pattern pattern(system, all.order);
  const std::vector<int> parent = elimination_tree(pattern), count = column_counts(pattern, parent);
  all.column_begin = amalgamate(fundamental(parent, count), parent, count);
  find_rows(pattern, parent, all);
  return all;
}

}  // namespace malha
