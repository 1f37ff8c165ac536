// SPDX-License-Identifier: Apache-2.0
// The tree of supernodes cut into tasks that do not touch each other, and what lies above them.
#pragma once
#include <vector>

#include "host/filter/supernodes.h"

namespace malha {

struct Subtrees {
  std::vector<std::vector<int>> tasks;  // supernodes of each, ascending: whole subtrees
  std::vector<int> top;                 // the others, ascending: ancestors of these
};

/// Depends on the tree alone. Tasks are about as long as each other, and there are no more than pay.
Subtrees subtrees(const Supernodes& all);

}  // namespace malha
