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

/// Partitions a graph. Returns the part, 0 .. parts - 1, of each vertex; cut edges have little weight, and loads are
/// balanced. A part may be empty if there are few vertices. The result is deterministic. Throws std::runtime_error if
/// METIS fails.
std::vector<int> cut_graph(const WeightedGraph& graph, int parts);

/// Mutex for METIS, whose random numbers are those of the C library, common to all threads.
std::mutex& metis_turn();

}  // namespace malha
