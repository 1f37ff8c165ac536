// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/runs.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "kernels/projection/patch.h"

namespace malha {

namespace {

constexpr int kMinLength = 4;  // shorter runs are cheaper to gather
constexpr int kMaxGap = 8;     // a longer gap costs more than the start of another run
constexpr int kFamilies =
    16;  // families of a grid; meshes with more families of fewer than kMinLength are not searched

/// The classes of a constraint's particles and their offsets from the first one. Constraints of a family can form runs.
using Family = std::array<int, 2 * kMostParticles>;

Family family_of(const int* particles, int arity, const std::vector<std::uint8_t>& class_of) {
  Family family{};
  for (int j = 0; j < arity; ++j)
    family[2 * j] = class_of[particles[j]], family[2 * j + 1] = particles[j] - particles[0];
  return family;
}

}  // namespace

int Runs::contiguous() const {
  return std::accumulate(runs.begin(), runs.end(), 0, [](int sum, const Run& run) {
    return sum + static_cast<int>(std::ranges::count_if(run.slots, [](int c) { return c >= 0; }));
  });
}

Runs find_runs(const std::vector<int>& particles, int arity, const std::vector<std::uint8_t>& class_of,
               const std::vector<int>& island) {
  const int count = static_cast<int>(particles.size()) / arity;
  const auto island_of = [&](int c) { return island.empty() ? 0 : island[c]; };
  struct Island {
    int constraints = 0;
    std::map<Family, std::size_t> rank;  // of its families, by first appearance: the order of the sweep
    bool is_irregular() const { return static_cast<int>(rank.size()) > kFamilies + constraints / kMinLength; }
  };
  std::map<int, Island> islands;
  for (int c = 0; c < count; ++c) ++islands[island_of(c)].constraints;
  std::vector<std::map<Family, std::size_t>::const_iterator> family_of_constraint(count);
  for (int c = 0; c < count; ++c)
    if (Island& own = islands.at(island_of(c)); !own.is_irregular())
      family_of_constraint[c] =
          own.rank.try_emplace(family_of(&particles[c * arity], arity, class_of), own.rank.size()).first;
  Runs result;
  std::vector<std::map<Family, std::vector<int>>> by_rank;  // a family of the same rank in several islands is one
  for (int c = 0; c < count; ++c) {
    if (islands.at(island_of(c)).is_irregular()) {
      result.loose.push_back(c);
      continue;
    }
    const auto& [family, rank] = *family_of_constraint[c];
    if (by_rank.size() <= rank) by_rank.resize(rank + 1);
    by_rank[rank][family].push_back(c);
  }
  const auto at = [&](int c) { return particles[c * arity]; };
  for (auto& families : by_rank)
    for (auto& [name, family] : families) {
      std::ranges::stable_sort(family, {}, at);
      // Two equal constraints would have the same slot, so that the second one starts another run.
      const auto follows = [&](int c, int before) { return at(c) > at(before) && at(c) - at(before) <= kMaxGap; };
      Run* run = nullptr;
      int last = 0;  // constraint of the run
      for (auto begin = family.begin(), end = begin; begin != family.end(); begin = end) {
        for (end = begin + 1; end != family.end() && follows(*end, end[-1]) && island_of(*end) == island_of(*begin);)
          ++end;
        if (end - begin < kMinLength) {
          result.loose.insert(result.loose.end(), begin, end);
          continue;
        }
        if (!run || !follows(*begin, last)) run = &result.runs.emplace_back();
        const int first = run->slots.empty() ? at(*begin) : at(last) + 1 - static_cast<int>(run->slots.size());
        last = end[-1];
        run->slots.resize(at(last) - first + 1, -1);
        for (auto c = begin; c != end; ++c) run->slots[at(*c) - first] = *c;
      }
    }
  std::ranges::sort(result.loose);
  return result;
}

}  // namespace malha
