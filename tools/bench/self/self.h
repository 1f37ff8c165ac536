// SPDX-License-Identifier: Apache-2.0
// malha bench self: what self-collision costs a particle and substep.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

/// What "--case" may name.
const std::vector<std::string>& self_case_names();

struct SelfOptions : MeasuringOptions {
  std::vector<std::string> cases;  // empty: all, or the stack alone if `n` is given
  std::vector<int> n;              // particles, about; empty: those of each case
};

/// Runs, prints a table as it goes, and writes self.json (the rows), self_machine.json and self.txt into the folder.
/// Throws InputError, Diverged, and std::runtime_error where something cannot be written.
void run_self(const SelfOptions& options);

}  // namespace malha::bench
