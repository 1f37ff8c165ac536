// SPDX-License-Identifier: Apache-2.0
// Graph colouring: what has one colour shares nothing, so that it can be worked on at once.
#pragma once
#include <cstdint>
#include <vector>

namespace malha {

/// Which colours are in use at each of a number of places, 64 to a word; words are added when a colour needs them.
class UsedColours {
 public:
  explicit UsedColours(std::size_t places) : words_(1, std::vector<std::uint64_t>(places, 0)) {}
  /// The lowest colour that none of these places uses.
  int lowest_free(const int* places, int count) const;
  void use(int colour, const int* places, int count);

 private:
  std::vector<std::vector<std::uint64_t>> words_;
};

struct Colouring {
  std::vector<int> colour;  // of each constraint, 0 ..
  int count = 0;            // colours; as many as it takes
};

/// Greedy, in creation order: each constraint takes the lowest colour free at all its movable particles.
/// `particles` holds `arity` indices a constraint. Depends on its arguments alone. Creation order is also the stabler
/// sweep (lexicographic sweeps from the pins down inject energy).
Colouring colour(const std::vector<int>& particles, int arity, const std::vector<bool>& pinned);

}  // namespace malha
