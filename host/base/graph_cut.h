// SPDX-License-Identifier: Apache-2.0
// A graph cut into parts by METIS.
#pragma once
#include <mutex>
#include <vector>

namespace malha {

/// Vertex i has the neighbours to[begin[i]] .. to[begin[i + 1] - 1]; each edge stands at both of its ends, with the
/// same weight.
struct WeightedGraph {
  std::vector<int> begin{0}, to, weight;
  std::vector<int> load;  // of each vertex
  int count() const { return static_cast<int>(begin.size()) - 1; }
};

/// The part, 0 .. parts - 1, of each vertex: edges of little weight are cut, loads are alike. A part may be empty where
/// there are few vertices. The same every time. Throws std::runtime_error where METIS gives up.
std::vector<int> cut_graph(const WeightedGraph& graph, int parts);

/// Held while METIS runs: its random numbers are those of the C library, for all threads together.
std::mutex& metis_turn();

}  // namespace malha
