// SPDX-License-Identifier: Apache-2.0
// malha bench filter: the time of a product of Desbrun's filter, dense and sparse, compared with OpenBLAS and with
// memory bandwidth, and how many particles run in real time.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

struct FilterOptions : MeasuringOptions {
  FilterOptions() { seconds = 0.1; }
  std::vector<int> n;                // sides of the grid; empty: the default sizes
  std::vector<std::string> kernels;  // "dense", "sparse", "step"; empty: all, or no step where n is given
};

/// Runs the benchmark and prints its table to standard output, size by size. After each size it writes filter.json (the
/// rows), filter_machine.json, filter.txt, filter.svg and filter.png into the folder. Throws InputError if memory is
/// too small, and std::runtime_error if a file cannot be written.
void run_filter(const FilterOptions& options);

}  // namespace malha::bench
