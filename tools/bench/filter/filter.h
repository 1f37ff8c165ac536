// malha bench filter: what a product of Desbrun's filter costs, dense and sparse, beside OpenBLAS and what memory
// allows, and how many particles run in real time.
#pragma once
#include <string>
#include <vector>

namespace malha::bench {

struct FilterOptions {
  std::vector<int> n;                // sides of the grid. Empty: the common ones
  std::vector<int> threads;          // empty: 1 and all cores
  std::vector<std::string> kernels;  // "dense", "sparse", "step"; empty: all, or no step where n is given
  int repeats = 5;
  double seconds = 0.1;  // of each repeat
  std::string json;      // a further file for the rows; empty: none
  std::string out = "out/bench_filter";
};

/// Runs, prints a table to standard output as it goes, and after each size writes filter.json (the rows),
/// filter_machine.json, filter.txt, filter.svg and filter.png into the folder. Throws InputError for what does not fit
/// into memory, and std::runtime_error where something cannot be written.
void run_filter(const FilterOptions& options);

}  // namespace malha::bench
