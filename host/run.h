// A whole run of a scene: steps, frames, pictures, checkpoints and the report in one folder.
#pragma once
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/simulation.h"

namespace malha {

struct RunOptions {
  std::string out;                    // the folder of the results; made where it is missing
  std::optional<std::int64_t> steps;  // stop at this step; otherwise the scene's duration
  bool resume = false;                // continue from the folder's checkpoint
};

struct Progress {
  std::int64_t step, steps;
  double time;     // s, simulated
  double step_ms;  // of the last step
};

struct RunResult {
  bool interrupted = false;
  bool complete = false;           // the scene's whole duration was run
  std::vector<std::string> unmet;  // expectations; only looked at where complete
  std::string report;              // what was written to report.json
};

/// Writes to options.out: report.json, frames/ (outputs.every), picture.png, storyboard.png and pictures/
/// (outputs.picture), checkpoint.malha (outputs.checkpoint_every, and when `stop` became true). Steps until the end
/// or until `stop`. Throws InputError before anything is written, Diverged after writing a report that says so;
/// frames and checkpoints that were written stay.
RunResult run(const Scene& scene, const SimulationOptions& simulation_options, const RunOptions& options,
              const std::function<void(const Progress&)>& progress, const std::atomic<bool>& stop);

}  // namespace malha
