// SPDX-License-Identifier: Apache-2.0
// malha bench projection: the time of a projection, compared with Bullet and with a lower bound from the machine's
// bandwidth and arithmetic.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

struct ProjectionOptions : MeasuringOptions {
  std::vector<int> n;  // sides of the grid, or particles of the irregular mesh; empty: the default sizes
  std::string only;    // "grid" or "irregular"; empty: both, or the grid alone if n is given
};

/// Runs the benchmark and prints its table to standard output, case by case. After each case it writes projection.json
/// (the rows), projection_machine.json, projection.txt, projection.svg and projection.png into the folder. Throws
/// InputError if memory is too small, Diverged, and std::runtime_error if a file cannot be written.
void run_projection(const ProjectionOptions& options);

}  // namespace malha::bench
