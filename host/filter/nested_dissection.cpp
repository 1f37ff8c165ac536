// SPDX-License-Identifier: Apache-2.0
#include <metis.h>

#include <mutex>
#include <numeric>
#include <stdexcept>
#include <string>

#include "host/filter/elimination_order.h"

namespace malha {

static_assert(sizeof(idx_t) == sizeof(int), "METIS as Debian builds it: 32-bit indices");

std::vector<int> elimination_order(const SpringSystem& system) {
  static std::mutex metis_turn;  // METIS seeds the C library's rand(), which is common to all threads
  std::vector<int> order(system.count());
  std::iota(order.begin(), order.end(), 0);
  std::vector<idx_t> begin, column, inverse;
  for (const SystemBlock& block : system.blocks) {
    if (block.count < kLeastOrdered) continue;
    const int first = system.begin[block.first];
    begin.clear(), column.clear();
    for (int i = block.first; i <= block.first + block.count; ++i) begin.push_back(system.begin[i] - first);
    for (int k = 0; k < begin.back(); ++k) column.push_back(system.column[first + k] - block.first);
    inverse.resize(block.count);
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;  // METIS then finds the same order in every run
    idx_t count = block.count;
    idx_t* perm = &order[block.first];
    const std::lock_guard<std::mutex> lock(metis_turn);
    if (METIS_NodeND(&count, begin.data(), column.data(), nullptr, options, perm, inverse.data()) != METIS_OK)
      throw std::runtime_error("METIS could not order a system of " + std::to_string(count) + " particles");
    for (int i = 0; i < block.count; ++i) perm[i] += block.first;
  }
  return order;
}

}  // namespace malha
