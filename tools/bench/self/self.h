// SPDX-License-Identifier: Apache-2.0
// malha bench self: the time of self-collision, per particle and substep.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

/// The cases that "--case" accepts.
const std::vector<std::string>& self_case_names();

struct SelfOptions : MeasuringOptions {
  std::vector<std::string> cases;  // empty: all, or the stack alone if `n` is given
  std::vector<int> n;              // particles, approximately; empty: the default of each case
};

/// Runs the benchmark, prints its table line by line, and writes self.json (the rows), self_machine.json and self.txt
/// into the folder. Throws InputError, Diverged, and std::runtime_error if a file cannot be written.
void run_self(const SelfOptions& options);

}  // namespace malha::bench
