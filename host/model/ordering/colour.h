// SPDX-License-Identifier: Apache-2.0
// Greedy graph colouring: constraints of one colour share no movable particle, so that they can be solved in parallel.
#pragma once
#include <cstdint>
#include <vector>

namespace malha {

/// The colours in use at each of a number of nodes, as bits, 64 colours to a word. Words are added as colours need
/// them.
class UsedColours {
 public:
  explicit UsedColours(std::size_t nodes) : words_(1, std::vector<std::uint64_t>(nodes, 0)) {}
  /// The lowest colour that none of these nodes uses.
  int lowest_free(const int* nodes, int count) const;
  /// Marks the colour as used at these nodes.
  void use(int colour, const int* nodes, int count);

 private:
  std::vector<std::vector<std::uint64_t>> words_;
};

struct Colouring {
  std::vector<int> colour;  // of each constraint, from 0
  int count = 0;            // number of colours
};

/// Colours constraints greedily in creation order: each gets the lowest colour that is free at all its movable
/// particles. `particles` has `arity` indices for each constraint. The result depends on the arguments alone. Creation
/// order is also the more stable order of a sweep: lexicographic sweeps from the pins downwards add energy.
Colouring colour(const std::vector<int>& particles, int arity, const std::vector<bool>& pinned);

}  // namespace malha
