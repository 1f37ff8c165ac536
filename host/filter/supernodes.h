// SPDX-License-Identifier: Apache-2.0
// The structure of the Cholesky factor of a spring system: order of elimination, and columns with the same rows taken
// together (supernodes), children before parents.
#pragma once
#include <cstdint>
#include <vector>

#include "host/filter/system.h"

namespace malha {

struct Supernodes {
  std::vector<int> order;         // unknown of each column
  std::vector<int> column_begin;  // of each supernode; and one more
  std::vector<int> row_begin;     // of each supernode's rows below its own columns; and one more
  std::vector<int> rows;          // column numbers, ascending
  std::vector<int> parent;        // -1: none
  int count() const { return static_cast<int>(parent.size()); }
  int columns(int s) const { return column_begin[s + 1] - column_begin[s]; }
  int below(int s) const { return row_begin[s + 1] - row_begin[s]; }
  int height(int s) const { return columns(s) + below(s); }  // of its panel
  /// Numbers of the panels, without padding.
  std::int64_t entries() const;
};

/// Liu's elimination tree of the system in elimination_order(), or in the given order of its unknowns, and small
/// supernodes amalgamated with their parents, as in CHOLMOD (Chen, Davis, Hager, Rajamanickam 2008), at the price of
/// some zeros.
Supernodes supernodes(const SpringSystem& system);
Supernodes supernodes(const SpringSystem& system, const std::vector<int>& elimination_order);

/// Partition of the tree of supernodes into independent subtrees, the tasks, and the top above them.
struct Subtrees {
  std::vector<std::vector<int>> tasks;  // supernodes of each, ascending: whole subtrees
  std::vector<int> top;                 // the others, ascending: ancestors of these
};

/// The partition depends on the tree alone. Tasks have about equal work, and are no more than pay for their overhead.
Subtrees subtrees(const Supernodes& all);

}  // namespace malha
