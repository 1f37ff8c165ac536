// SPDX-License-Identifier: Apache-2.0
// State of self-collision that later substeps depend on: its lists in checkpoints, and their checks.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "host/base/check_numbers.h"
#include "kernels/simd/vec.h"

namespace malha {

/// The last broad phase, whose start and paths are in SelfMemory.
struct SearchMemory {
  static constexpr std::int32_t kMaxAhead = 128;
  std::int32_t valid = 0;             // 1 if it is still valid
  std::int32_t age = 1, horizon = 1;  // substeps that it has served, and substeps that searches look ahead
  std::int32_t crosses = 0;           // 1 if searches leave out pairs around intersections of the start
};

/// Empty without self-collision; otherwise the first four lists have an element for each particle, the others one.
template <class R>
struct SelfMemory {
  std::vector<std::array<R, 3>> x0;     // positions without intersections, from the origin, m
  std::vector<std::array<R, 4>> from;   // of the last search: its start, from the origin, and the margin, m
  std::vector<std::array<R, 3>> way;    // of the last search: displacements along the paths, m
  std::vector<R> contact_distance;      // m; 0: to be set from the distances at the next substep
  std::vector<Vector3<double>> origin;  // m
  std::vector<SearchMemory> search;
  std::vector<std::int64_t> substeps_kinematic_penetration;  // see SelfStats

  /// Calls f(list) for every list, in the order of checkpoints.
  template <class Memory, class F>
  static void for_each_list(Memory& memory, const F& f) {
    f(memory.x0), f(memory.from), f(memory.way), f(memory.contact_distance);
    f(memory.origin), f(memory.search), f(memory.substeps_kinematic_penetration);
  }
};

/// Memory with these positions (from the same origin), contact distances that are to be set from them, and no valid
/// search; the rest as `before`.
template <class R>
SelfMemory<R> unsearched(std::vector<std::array<R, 3>> x0, const SelfMemory<R>& before = {}) {
  const std::size_t n = x0.size();
  SelfMemory<R> memory{std::move(x0),
                       std::vector<std::array<R, 4>>(n),
                       std::vector<std::array<R, 3>>(n),
                       std::vector<R>(n),
                       {{0, 0, 0}},
                       {SearchMemory{}},
                       {0}};
  if (before.search.empty()) return memory;
  memory.origin = before.origin, memory.search[0].crosses = before.search[0].crosses;
  memory.substeps_kinematic_penetration = before.substeps_kinematic_penetration;
  return memory;
}

/// Throws InputError for memory that no run can have saved, with which a solver would never end.
template <class R>
void check(const SelfMemory<R>& memory, const std::string& file) {
  check_numbers(memory.x0, "parted positions", file), check_numbers(memory.from, "positions of a search", file);
  check_numbers(memory.way, "ways of a search", file);
  for (const auto& a : memory.from)
    if (a[3] < 0) refuse(file, "reach of a search", shown(double(a[3])), "at least 0");
  check_distances(memory.contact_distance, "contact distance", file);
  const auto check_vector = [&](const char* what, const Vector3<double>& a) {
    for (const double number : {a.x, a.y, a.z})
      if (!(std::abs(number) <= kMostSquared)) refuse(file, what, shown(number), "numbers up to 1e18");
  };
  const auto check_count = [&](const char* what, std::int32_t count, int least, int most) {
    if (count < least || count > most)
      refuse(file, what, std::to_string(count), std::to_string(least) + " to " + std::to_string(most));
  };
  for (const Vector3<double>& origin : memory.origin) check_vector("origin of parted positions", origin);
  for (const SearchMemory& search : memory.search) {
    check_count("search that serves", search.valid, 0, 1), check_count("bodies that cross", search.crosses, 0, 1);
    check_count("substeps ahead of a search", search.horizon, 1, SearchMemory::kMaxAhead);
    check_count("substeps of a search", search.age, 1, std::numeric_limits<int>::max());
  }
  for (const std::int64_t substeps : memory.substeps_kinematic_penetration)
    if (substeps < 0) refuse(file, "substeps with kinematic penetration", std::to_string(substeps), "at least 0");
}

}  // namespace malha
