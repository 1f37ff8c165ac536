// SPDX-License-Identifier: Apache-2.0
// State of collisions with edges of the environment that later substeps depend on, for checkpoints.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace malha {

/// Positions without intersections, and the last search of every group of objects, one group after the other, in the
/// frame of its objects.
template <class R>
struct EdgeMemory {
  std::vector<std::array<R, 3>> x0;         // m
  std::vector<std::array<R, 3>> from, way;  // m, of every particle: start and displacement at the search
  std::vector<R> contact_distance;          // m, of every particle
  std::vector<std::int64_t> valid;          // of every group: 1 if there is a search
};

/// Memory of this many groups, with these positions and no valid search.
template <class R>
EdgeMemory<R> unsearched_edges(std::size_t groups, const std::vector<std::array<R, 3>>& x0) {
  const std::size_t count = groups * x0.size();
  const std::vector<std::array<R, 3>> none(count);
  return {x0, none, none, std::vector<R>(count), std::vector<std::int64_t>(groups)};
}

}  // namespace malha
