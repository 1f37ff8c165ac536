// SPDX-License-Identifier: Apache-2.0
// A whole run of a scene: steps, frames, pictures, checkpoints and the report in one folder.
#pragma once
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha {

inline constexpr double kMostSteps = 1e9;  // of a time that is asked for

struct RunOptions {
  std::string out;                         // the folder of the results; made where it is missing
  std::optional<std::int64_t> steps = {};  // stop at this step; otherwise the scene's duration
  std::string rounding = {};               // what is to be said of `steps` (report/whole_steps.h); may be empty
  bool resume = false;                     // continue from the folder's checkpoint
  std::function<void(const std::string&)> warn =
      {};                          // of each of warnings(), before the first step, and of momenta
                                   // that changed (report/momentum_drift.h), after the last; may be empty
  double checkpoint_seconds = 30;  // of the clock, between checkpoints where outputs.checkpoint_every is not given
  std::function<void(const char*)> doing = {};  // what is begun that is not a step ("drawing a picture"); may be empty
  std::function<void()> ready = {};             // set-up is done: from here on `stop` is looked at; may be empty
};

struct Progress {
  std::int64_t step, steps;
  double time;     // s, simulated
  double step_ms;  // of the last step
};

struct RunResult {
  bool interrupted = false;
  bool complete = false;                         // it ended where the scene's duration ends
  bool pictures_missing = false;                 // it was stopped, and those of the end were not drawn
  std::vector<std::string> failed_expectations;  // expectations; only looked at where complete
  std::string summary;                           // the lines that a person wants
};

/// Refuses more frames until step `last` than a file may hold; `before`: those of the run that this one resumes.
void check_frames(const Simulation& simulation, std::int64_t last, std::optional<std::int64_t> before = std::nullopt);

/// Steps until the end or until `stop`, and writes to options.out: report.json, checkpoint.malha (of the end, and
/// before it every outputs.checkpoint_every steps or checkpoint_seconds), frames/ (outputs.every), picture.png,
/// storyboard.png and pictures/ (outputs.picture; a resumed run's storyboard shows what that run saw; after `stop` none
/// is drawn any more). The results of an earlier run there are replaced. Throws InputError before anything is written
/// or removed, also where another run writes to the folder; Diverged after writing a report that says so, where frames
/// and checkpoints that were written stay; std::runtime_error where something cannot be written.
RunResult run(const Scene& scene, const SimulationOptions& simulation_options, const RunOptions& options,
              const std::function<void(const Progress&)>& progress, const std::atomic<bool>& stop);

}  // namespace malha
