// SPDX-License-Identifier: Apache-2.0
// report.json: what was run, on what, how fast and how well.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "host/model/model.h"
#include "host/report/launches.h"
#include "host/report/step_statistics.h"
#include "host/solver/solver.h"

namespace malha {

struct RunTimes {
  double model_seconds = 0, solver_seconds = 0;  // set-up
  StepStatistics steps;                          // how long each took
  int steps_alone = 0;                           // steps on one thread of several (see AdaptiveThreadCount)
  int splits = 0, layouts = 0;                   // vertices that tore, and how often all was laid out anew for them
  double layout_seconds = 0;                     // spent on that
  std::int64_t most_crossings = 0;               // at any of the times that they were counted
  std::int64_t crossings_counted = 0;            // how often
  LargestStrains strains;                        // of the steps since this part of the run began
  std::vector<Launches> launches;                // of the first step, in the order in which kernels came
};

/// ms; 0 without steps.
double median_step_ms(const RunTimes& times);

/// Numbers with their names, in the order in which they are shown.
using Parts = std::vector<std::pair<std::string, double>>;

/// What set-up spent its time on, s. One after the other: load, order, connect, patches, colour, layout, collision, and
/// levels where there are any.
Parts setup_parts(const Model& model, const SolverStats& facts);

/// What takes up how many bytes: particles, constraints, patches (with the memories that visits work in), collision
/// without Embree's own, the model, and levels where there are any.
Parts memory_parts(const Model& model, const SolverStats& facts);

/// The most memory that this process has held, MiB.
double peak_memory_mib();

/// What the report says of the present state, as JSON.
std::string measures_json(const Model& model, const Solver& solver, const RunTimes& times);

/// JSON with snake_case names and the unit as suffix. `status`: "finished", "interrupted" or "diverged"; a diverged
/// state is not measured. `input` holds the scene, every value spelled out, with paths that start from `folder`, where
/// the report will lie. `notes`: where it diverged, or which expectations are not met.
std::string report_json(const std::string& status, const std::vector<std::string>& notes, const Model& model,
                        const Solver& solver, int threads, const RunTimes& times, const std::string& folder);

}  // namespace malha
