// Graph colouring: constraints of one colour share no movable particle, so that they can be projected at once.
#pragma once
#include <vector>

namespace malha {

struct Colouring {
  std::vector<int> colour;  // of each constraint, 0 ..
  int count = 0;            // colours; as many as it takes
};

/// Greedy, in creation order: each constraint takes the lowest colour free at all its movable particles.
/// `particles` holds `arity` indices a constraint. Depends on its arguments alone. Creation order is also the stabler
/// sweep (lexicographic sweeps from the pins down inject energy).
Colouring colour(const std::vector<int>& particles, int arity, const std::vector<bool>& pinned);

}  // namespace malha
