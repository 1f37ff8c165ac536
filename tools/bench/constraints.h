// malha bench constraints: what every kind of constraint costs, each alone on a body of its own.
#pragma once
#include <string>
#include <vector>

namespace malha::bench {

struct ConstraintOptions {
  int n = 100'000;           // particles, about
  std::vector<int> threads;  // empty: 1 and all cores
  int repeats = 5;
  double seconds = 0.5;  // of each repeat
  std::string json;      // a further file for the rows; empty: none
  std::string out = "out/bench_constraints";
};

/// Runs, prints a table to standard output as it goes, and after each line writes constraints.json (the rows),
/// constraints_machine.json and constraints.txt into the folder. Throws Diverged, and std::runtime_error where
/// something cannot be written.
void run_constraints(const ConstraintOptions& options);

}  // namespace malha::bench
