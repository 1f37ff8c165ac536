// SPDX-License-Identifier: Apache-2.0
// malha bench projection: what a projection costs, beside Bullet, the machine's bandwidth, and the floor.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

struct ProjectionOptions : MeasuringOptions {
  std::vector<int> n;  // sides of the grid; particles of the irregular mesh. Empty: those of the common case
  std::string only;    // "grid" or "irregular"; empty: both, or the grid alone where n is given
};

/// Runs, prints a table to standard output as it goes, and after each case writes projection.json (the rows),
/// projection_machine.json, projection.txt, projection.svg and projection.png into the folder. Throws InputError for
/// what does not fit into memory, Diverged, and std::runtime_error where something cannot be written.
void run_projection(const ProjectionOptions& options);

}  // namespace malha::bench
