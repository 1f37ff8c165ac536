#include "host/solver/colour.h"

#include <bit>
#include <cstdint>

namespace malha {

namespace {

/// The colours in use at each particle, 64 to a word; words are added when a colour needs them.
class UsedColours {
 public:
  explicit UsedColours(std::size_t particles) : words_(1, std::vector<std::uint64_t>(particles, 0)) {}

  int lowest_free(const int* particles, int arity, const std::vector<bool>& pinned) {
    for (std::size_t word = 0;; ++word) {
      if (word == words_.size()) words_.emplace_back(words_[0].size(), 0);
      std::uint64_t used = 0;
      for (int j = 0; j < arity; ++j)
        if (!pinned[particles[j]]) used |= words_[word][particles[j]];
      if (~used != 0) return static_cast<int>(64 * word) + std::countr_one(used);
    }
  }

  void use(int colour, const int* particles, int arity, const std::vector<bool>& pinned) {
    for (int j = 0; j < arity; ++j)
      if (!pinned[particles[j]]) words_[colour / 64][particles[j]] |= std::uint64_t{1} << (colour % 64);
  }

 private:
  std::vector<std::vector<std::uint64_t>> words_;
};

}  // namespace

Colouring colour(const std::vector<int>& particles, int arity, const std::vector<bool>& pinned) {
  Colouring result;
  result.colour.resize(particles.size() / arity);
  UsedColours used(pinned.size());
  for (std::size_t c = 0; c < result.colour.size(); ++c) {
    const int* of = &particles[c * arity];
    const int chosen = used.lowest_free(of, arity, pinned);
    used.use(chosen, of, arity, pinned);
    result.colour[c] = chosen;
    if (chosen >= result.count) result.count = chosen + 1;
  }
  return result;
}

}  // namespace malha
