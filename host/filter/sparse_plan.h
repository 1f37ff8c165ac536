// SPDX-License-Identifier: Apache-2.0
// Memory layout of a sparse filter: panels, segments of the work vector, and contributions between them.
#pragma once
#include <cstdint>
#include <vector>

#include "host/filter/subtrees.h"
#include "kernels/filter/sparse_filter.h"

namespace malha {

/// The lists of SparseView.
struct SparsePlan {
  std::vector<Panel> panels;  // task by task, each in the order of elimination; the top's at the end
  std::vector<int> panel_of;  // of each supernode
  std::vector<int> rows;
  std::vector<FilterTask> tasks;
  std::vector<int> above, sum, from;
  std::vector<int> particle;  // of the work vector's places; -1: a contribution
  std::int64_t values = 0;    // numbers of all panels
  int most_rows = 0;          // of a panel, whole blocks
};

SparsePlan plan_sparse(const SpringSystem& system, const Supernodes& all, const Subtrees& cut);

}  // namespace malha
