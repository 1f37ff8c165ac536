// SPDX-License-Identifier: Apache-2.0
#include "host/base/graph_cut.h"

#include <metis.h>

#include <stdexcept>
#include <string>

namespace malha {

static_assert(sizeof(idx_t) == sizeof(int), "METIS as Debian builds it: 32-bit indices");

std::mutex& metis_turn() {
  static std::mutex turn;
  return turn;
}

std::vector<int> cut_graph(const WeightedGraph& graph, int parts) {
  std::vector<int> part(graph.count(), 0);
  if (parts == 1) return part;
  WeightedGraph own = graph;  // METIS takes pointers to data that is not const
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  idx_t count = own.count(), loads = 1, of = parts, cut = 0;
  const std::lock_guard<std::mutex> lock(metis_turn());
  const int status = METIS_PartGraphKway(&count, &loads, own.begin.data(), own.to.data(), own.load.data(), nullptr,
                                         own.weight.data(), &of, nullptr, nullptr, options, &cut, part.data());
  if (status != METIS_OK)
    throw std::runtime_error("METIS could not cut a graph of " + std::to_string(count) + " vertices into " +
                             std::to_string(parts) + " parts");
  return part;
}

}  // namespace malha
