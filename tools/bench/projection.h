// malha bench projection: what a projection costs, beside Bullet, the machine's bandwidth, and the floor.
#pragma once
#include <string>
#include <vector>

namespace malha::bench {

struct ProjectionOptions {
  std::vector<int> n;        // sides of the grid; particles of the irregular mesh. Empty: those of the common case
  std::vector<int> threads;  // empty: 1 and all cores
  std::string only;          // "grid" or "irregular"; empty: both, or the grid alone where n is given
  int repeats = 5;
  double seconds = 1;  // of each repeat
  std::string json;    // a further file for the rows; empty: none
  std::string out = "out/bench_projection";
};

/// Runs, prints a table to standard output as it goes, and after each case writes projection.json (the rows),
/// projection_machine.json, projection.txt, projection.svg and projection.png into the folder. Throws InputError for
/// what does not fit into memory, Diverged, and std::runtime_error where something cannot be written.
void run_projection(const ProjectionOptions& options);

}  // namespace malha::bench
