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

inline constexpr double kMostSteps = 1e9;  // largest number of steps of a run

struct RunOptions {
  std::string out;                         // the folder of the results; made if it is missing
  std::optional<std::int64_t> steps = {};  // stop at this step; the scene's duration if none
  std::string rounding = {};  // message about rounding to whole `steps` (report/whole_steps.h); may be empty
  bool resume = false;        // continue from the folder's checkpoint
  std::function<void(const std::string&)> warn =
      {};                          // of each of warnings(), before the first step, and of momenta
                                   // that changed (report/momentum_drift.h), after the last; may be empty
  double checkpoint_seconds = 30;  // of the clock, between checkpoints, if outputs.checkpoint_every is not given
  std::function<void(const char*)> on_activity =
      {};  // called with an activity other than a step when it begins ("drawing a picture"); may be empty
  std::function<void()> ready = {};  // called after set-up, from when on `stop` has an effect; may be empty
};

struct Progress {
  std::int64_t step, steps;
  double time;     // s, simulated
  double step_ms;  // duration of the last step
};

struct RunResult {
  bool interrupted = false;
  bool complete = false;                         // it ran to the end of the scene's duration
  bool pictures_missing = false;                 // it was stopped before the pictures of the end were drawn
  std::vector<std::string> failed_expectations;  // checked only if complete
  std::string summary;                           // lines for the user
};

/// Refuses more frames up to step `last` than a file may hold. `before`: frames of the run that this one resumes.
void check_frames(const Simulation& simulation, std::int64_t last, std::optional<std::int64_t> before = std::nullopt);

/// Runs to the end or until `stop`, and writes to options.out: report.json, checkpoint.malha (of the end, and before it
/// every outputs.checkpoint_every steps or checkpoint_seconds), frames/ (outputs.every), picture.png, storyboard.png
/// and pictures/ (outputs.picture; the storyboard of a resumed run starts where it resumed; none is drawn after
/// `stop`). The results of an earlier run there are replaced. Throws InputError before anything is written or removed,
/// also if another run writes to the folder; Diverged after writing a report of it, where frames and checkpoints stay;
/// std::runtime_error if something cannot be written.
RunResult run(const Scene& scene, const SimulationOptions& simulation_options, const RunOptions& options,
              const std::function<void(const Progress&)>& progress, const std::atomic<bool>& stop);

}  // namespace malha
