// SPDX-License-Identifier: Apache-2.0
// Partition of the tree of supernodes into independent subtrees, the tasks, and the top above them.
#pragma once
#include <vector>

#include "host/filter/supernodes.h"

namespace malha {

struct Subtrees {
  std::vector<std::vector<int>> tasks;  // supernodes of each, ascending: whole subtrees
  std::vector<int> top;                 // the others, ascending: ancestors of these
};

/// The partition depends on the tree alone. Tasks have about equal work, and are no more than pay for their overhead.
Subtrees subtrees(const Supernodes& all);

}  // namespace malha
