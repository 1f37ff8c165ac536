// SPDX-License-Identifier: Apache-2.0
// State of collisions with edges of the environment that later substeps depend on, for checkpoints.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/base/check_numbers.h"

namespace malha {

/// Positions without intersections, and the last search of every group of objects, one group after the other, in the
/// frame of its objects.
template <class R>
struct EdgeMemory {
  std::vector<std::array<R, 3>> x0;         // m
  std::vector<std::array<R, 3>> from, way;  // m, of every particle: start and displacement at the search
  std::vector<R> contact_distance;          // m, of every particle
  std::vector<std::int64_t> valid;          // of every group: 1 if there is a search

  /// Calls f(list) for every list, in the order of checkpoints.
  template <class Memory, class F>
  static void for_each_list(Memory& memory, const F& f) {
    f(memory.x0), f(memory.from), f(memory.way), f(memory.contact_distance), f(memory.valid);
  }
};

/// Memory of this many groups, with these positions and no valid search.
template <class R>
EdgeMemory<R> unsearched_edges(std::size_t groups, const std::vector<std::array<R, 3>>& x0) {
  const std::size_t count = groups * x0.size();
  const std::vector<std::array<R, 3>> none(count);
  return {x0, none, none, std::vector<R>(count), std::vector<std::int64_t>(groups)};
}

/// Throws InputError for memory that no run can have saved.
template <class R>
void check(const EdgeMemory<R>& memory, const std::string& file) {
  check_numbers(memory.x0, "positions before edges", file);
  check_numbers(memory.from, "positions of a search of edges", file);
  check_numbers(memory.way, "ways of a search of edges", file);
  check_distances(memory.contact_distance, "contact distance", file);
  for (const std::int64_t serves : memory.valid)
    if (serves < 0 || serves > 1) refuse(file, "search of edges that serves", std::to_string(serves), "0 or 1");
}

}  // namespace malha
