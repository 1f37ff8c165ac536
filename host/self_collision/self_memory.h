// SPDX-License-Identifier: Apache-2.0
// State of self-collision that later substeps depend on, for checkpoints.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace malha {

/// The last broad phase, the frame in which its boxes are at rest, and what a run has counted.
struct SearchMemory {
  static constexpr std::int32_t kMaxAhead = 8;
  std::array<double, 3> origin{};  // m, of x0 and of `from`
  std::array<double, 3> frame_offset{},
      frame_displacement{};           // m: of the frame, from the search to the start of the substep, and in it
  std::int32_t valid = 0;             // 1 if the last search is still valid
  std::int32_t age = 1, horizon = 1;  // substeps that it has served, and substeps that searches look ahead
  std::int32_t crosses = 0;           // 1 if intersections of the start persist
  std::int64_t substeps_kinematic_penetration =
      0;  // substeps in which kinematic particles may have gone through bodies
};

template <class R>
struct SelfMemory {
  std::vector<std::array<R, 3>> x0;    // positions without intersections, from the origin, m
  std::vector<std::array<R, 4>> from;  // of the last search: its start, and the margin around the paths, m
  std::vector<std::array<R, 3>> way;   // of the last search: displacements along the paths, m
  std::vector<R> contact_distance;     // m; 0: to be set from the distances at the next substep
  std::vector<SearchMemory> search;    // one element
};

/// Memory with these positions (from the same origin), contact distances that are to be set from them, and no valid
/// search; the rest as `before`.
template <class R>
SelfMemory<R> unsearched(std::vector<std::array<R, 3>> x0, const SearchMemory& before = {}) {
  const std::size_t n = x0.size();
  SearchMemory search;
  search.origin = before.origin, search.crosses = before.crosses,
  search.substeps_kinematic_penetration = before.substeps_kinematic_penetration;
  return {
      std::move(x0), std::vector<std::array<R, 4>>(n), std::vector<std::array<R, 3>>(n), std::vector<R>(n), {search}};
}

}  // namespace malha
