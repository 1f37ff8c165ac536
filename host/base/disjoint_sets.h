// SPDX-License-Identifier: Apache-2.0
// Disjoint sets (union-find).
#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

namespace malha {

/// The numbers from 0 on, initially each in a set of its own. The root of a set is its lowest number.
class DisjointSets {
 public:
  explicit DisjointSets(int numbers) : parent_(numbers) { std::iota(parent_.begin(), parent_.end(), 0); }

  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int a, int b) {
    const int i = root(a), j = root(b);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace malha
