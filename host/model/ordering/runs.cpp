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

Runs find_runs(const std::vector<int>& particles, int arity, const std::vector<std::uint8_t>& class_of) {
  const int count = static_cast<int>(particles.size()) / arity;
  Runs result;
  std::map<Family, int> number;
  std::vector<std::vector<int>> families;  // by first appearance: the order of the sweep
  for (int c = 0; c < count; ++c) {
    const auto [found, fresh] =
        number.try_emplace(family_of(&particles[c * arity], arity, class_of), static_cast<int>(families.size()));
    if (fresh) families.emplace_back();
    families[found->second].push_back(c);
    if (static_cast<int>(families.size()) > kFamilies + count / kMinLength) {
      result.loose.resize(count);
      std::iota(result.loose.begin(), result.loose.end(), 0);
      return result;
    }
  }
  for (auto& family : families) {
    const auto at = [&](int c) { return particles[c * arity]; };
    std::ranges::stable_sort(family, [&](int a, int b) { return at(a) < at(b); });
    for (auto begin = family.begin(), end = begin; begin != family.end(); begin = end) {
      // Two equal constraints would have the same slot, so that the second one starts another run.
      for (end = begin + 1; end != family.end() && at(*end) > at(end[-1]) && at(*end) - at(end[-1]) <= kMaxGap;) ++end;
      if (end - begin < kMinLength) {
        result.loose.insert(result.loose.end(), begin, end);
        continue;
      }
      Run& run = result.runs.emplace_back();
      run.slots.assign(at(end[-1]) - at(*begin) + 1, -1);
      for (auto c = begin; c != end; ++c) run.slots[at(*c) - at(*begin)] = *c;
    }
  }
  std::ranges::sort(result.loose);
  return result;
}

}  // namespace malha
