// SPDX-License-Identifier: Apache-2.0
// malha bench constraints: the time of each kind of constraint, alone on a body.
#pragma once
#include "tools/bench/counts.h"

namespace malha::bench {

struct ConstraintOptions : MeasuringOptions {
  ConstraintOptions() { seconds = 0.5; }
  int n = 100'000;  // particles, approximately
};

/// Runs the benchmark and prints its table line by line to standard output. After each line it writes
/// constraints.json (the rows), constraints_machine.json and constraints.txt into the folder. Throws Diverged, and
/// std::runtime_error if a file cannot be written.
void run_constraints(const ConstraintOptions& options);

}  // namespace malha::bench
