// SPDX-License-Identifier: Apache-2.0
// The memory of edges of the environment: what a later substep depends on.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace malha {

/// Positions in which nothing crosses; and of the last search of every group of objects, one group after the other, in
/// the frame of its objects.
template <class R>
struct EdgeMemory {
  std::vector<std::array<R, 3>> x0;         // m
  std::vector<std::array<R, 3>> from, way;  // m, of every particle: where it started, and how far it was expected to go
  std::vector<R> contact_distance;          // m, of every particle
  std::vector<std::int64_t> valid;          // of every group: 1 where there is a search
};

/// It is that of so many groups, from these positions, without a search that serves.
template <class R>
EdgeMemory<R> unsearched_edges(std::size_t groups, const std::vector<std::array<R, 3>>& x0) {
  const std::size_t count = groups * x0.size();
  const std::vector<std::array<R, 3>> none(count);
  return {x0, none, none, std::vector<R>(count), std::vector<std::int64_t>(groups)};
}

}  // namespace malha
