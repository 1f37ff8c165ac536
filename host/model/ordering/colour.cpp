// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/colour.h"

#include <algorithm>
#include <bit>

namespace malha {

int UsedColours::lowest_free(const int* nodes, int count) const {
  int colour = 0;
  for (const auto& word : words_) {
    std::uint64_t used = 0;
    for (int j = 0; j < count; ++j) used |= word[nodes[j]];
    if (~used != 0) return colour + std::countr_one(used);
    colour += 64;
  }
  return colour;
}

void UsedColours::use(int colour, const int* nodes, int count) {
  while (words_.size() <= static_cast<std::size_t>(colour / 64)) words_.emplace_back(words_[0].size(), 0);
  for (int j = 0; j < count; ++j) words_[colour / 64][nodes[j]] |= std::uint64_t{1} << (colour % 64);
}

Colouring colour(const std::vector<int>& particles, int arity, const std::vector<bool>& pinned) {
  Colouring result;
  result.colour.resize(particles.size() / arity);
  UsedColours used(pinned.size());
  std::vector<int> movable;
  for (std::size_t c = 0; c < result.colour.size(); ++c) {
    movable.clear();
    std::copy_if(&particles[c * arity], &particles[c * arity] + arity, std::back_inserter(movable),
                 [&](int i) { return !pinned[i]; });
    const int count = static_cast<int>(movable.size());
    const int chosen = used.lowest_free(movable.data(), count);
    used.use(chosen, movable.data(), count);
    result.colour[c] = chosen;
    result.count = std::max(result.count, chosen + 1);
  }
  return result;
}

}  // namespace malha
