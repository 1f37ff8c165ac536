// SPDX-License-Identifier: Apache-2.0
// Runs: sequences of constraints whose particles are consecutive, so that a pack of constraints is loaded and stored
// with plain vector accesses. On a grid with particles sorted by class all constraints are in runs.
#pragma once
#include <cstdint>
#include <vector>

namespace malha {

/// Constraints with the particles first[j] + slot, j < arity. Slots without a constraint are gaps.
struct Run {
  std::vector<int> slots;  // constraint of each slot, or -1
};

struct Runs {
  std::vector<Run> runs;
  std::vector<int> loose;  // the other constraints, in creation order
  int contiguous() const;  // number of constraints in runs
};

/// Finds the runs of constraints with `arity` indices in `particles` each. `class_of` is the class of each index; the
/// particles of a constraint have different ones. The j-th particles of all constraints of a run have the same class,
/// so that they share no particle. `island` of each constraint, if there are several: the constraints of each are in
/// runs, and in the order, in which they would be alone. Runs of several islands that follow one another are one.
Runs find_runs(const std::vector<int>& particles, int arity, const std::vector<std::uint8_t>& class_of,
               const std::vector<int>& island = {});

}  // namespace malha
