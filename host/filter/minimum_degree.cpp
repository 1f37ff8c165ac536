// SPDX-License-Identifier: Apache-2.0
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <numeric>

#include "host/filter/elimination_order.h"

namespace malha {

std::vector<int> minimum_degree_order(const SpringSystem& system) {
  std::vector<int> order(system.count());
  std::iota(order.begin(), order.end(), 0);
  for (const SystemBlock& block : system.blocks) {
    if (block.count < kLeastOrdered) continue;
    std::vector<Eigen::Triplet<float>> entries;
    for (int i = block.first; i < block.first + block.count; ++i) {
      entries.emplace_back(i - block.first, i - block.first, 1.0f);
      for (int k = system.begin[i]; k < system.begin[i + 1]; ++k)
        entries.emplace_back(system.column[k] - block.first, i - block.first, 1.0f);
    }
    Eigen::SparseMatrix<float, Eigen::ColMajor, int> pattern(block.count, block.count);
    pattern.setFromTriplets(entries.begin(), entries.end());
    Eigen::AMDOrdering<int>::PermutationType eliminated;
    Eigen::AMDOrdering<int>()(pattern, eliminated);
    for (int i = 0; i < block.count; ++i) order[block.first + i] = block.first + eliminated.indices()[i];
  }
  return order;
}

}  // namespace malha
