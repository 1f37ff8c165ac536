// SPDX-License-Identifier: Apache-2.0
// What of self-collision a later substep depends on.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace malha {

/// Of the last search, of the frame in which its boxes stand, and what a run has counted.
struct SearchMemory {
  static constexpr std::int32_t kMostAhead = 8;
  std::array<double, 3> origin{};                          // m, of places and of where searches started
  std::array<double, 3> frame_offset{}, frame_velocity{};  // m: from the search to the start of the substep, and in it
  std::int32_t valid = 0;                                  // whether there is one that still does
  std::int32_t age = 1, horizon = 1;                       // substeps that it did, and for which searches look ahead
  std::int32_t crosses = 0;                                // whether any of what crossed at the start still does
  std::int64_t driven_through = 0;  // substeps in which pins or objects may have gone through bodies
};

template <class R>
struct SelfMemory {
  std::vector<std::array<R, 3>> x0;    // positions without crossings, from the origin, m
  std::vector<std::array<R, 4>> from;  // of the last search: where it started, and how far beyond the ways it looked, m
  std::vector<std::array<R, 3>> way;
  std::vector<R> contact_distance;   // m; 0: as near as it is where the next substep begins
  std::vector<SearchMemory> search;  // one
};

/// With these positions from the same origin, everything as near as it is there, and no search that holds; else as it
/// was.
template <class R>
SelfMemory<R> unsearched(std::vector<std::array<R, 3>> x0, const SearchMemory& before = {}) {
  const std::size_t n = x0.size();
  SearchMemory search;
  search.origin = before.origin, search.crosses = before.crosses, search.driven_through = before.driven_through;
  return {
      std::move(x0), std::vector<std::array<R, 4>>(n), std::vector<std::array<R, 3>>(n), std::vector<R>(n), {search}};
}

}  // namespace malha
