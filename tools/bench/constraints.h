// SPDX-License-Identifier: Apache-2.0
// malha bench constraints: what every kind of constraint costs, each alone on a body of its own.
#pragma once
#include "tools/bench/counts.h"

namespace malha::bench {

struct ConstraintOptions : MeasuringOptions {
  ConstraintOptions() { seconds = 0.5; }
  int n = 100'000;  // particles, about
};

/// Runs, prints a table to standard output as it goes, and after each line writes constraints.json (the rows),
/// constraints_machine.json and constraints.txt into the folder. Throws Diverged, and std::runtime_error where
/// something cannot be written.
void run_constraints(const ConstraintOptions& options);

}  // namespace malha::bench
