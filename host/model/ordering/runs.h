// SPDX-License-Identifier: Apache-2.0
// Runs: constraints whose particles all advance by one from each to the next, so that a pack of them is read and
// written as whole vectors. A grid is made of nothing else once its particles are sorted by class.
#pragma once
#include <cstdint>
#include <vector>

namespace malha {

/// Constraints c with particles first[j] + (slot of c), j < arity. Slots without a constraint are gaps.
struct Run {
  std::vector<int> slots;  // a constraint, or -1
};

struct Runs {
  std::vector<Run> runs;
  std::vector<int> loose;  // the other constraints, in creation order
  int contiguous() const;  // constraints in runs
};

/// `particles`: `arity` indices a constraint. `class_of` each index: the particles of a constraint have different ones.
/// A run keeps to one class at each end, so that its constraints share no particle.
Runs find_runs(const std::vector<int>& particles, int arity, const std::vector<std::uint8_t>& class_of);

}  // namespace malha
