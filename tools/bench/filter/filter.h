// SPDX-License-Identifier: Apache-2.0
// malha bench filter: what a product of Desbrun's filter costs, dense and sparse, beside OpenBLAS and what memory
// allows, and how many particles run in real time.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

struct FilterOptions : MeasuringOptions {
  FilterOptions() { seconds = 0.1; }
  std::vector<int> n;                // sides of the grid. Empty: the common ones
  std::vector<std::string> kernels;  // "dense", "sparse", "step"; empty: all, or no step where n is given
};

/// Runs, prints a table to standard output as it goes, and after each size writes filter.json (the rows),
/// filter_machine.json, filter.txt, filter.svg and filter.png into the folder. Throws InputError for what does not fit
/// into memory, and std::runtime_error where something cannot be written.
void run_filter(const FilterOptions& options);

}  // namespace malha::bench
