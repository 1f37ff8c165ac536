// SPDX-License-Identifier: Apache-2.0
// The report of a run, report.json: input, machine, times, memory and measured state.
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
  double model_seconds = 0, solver_seconds = 0;  // parts of set-up
  StepStatistics steps;                          // durations of the steps
  int steps_alone = 0;                           // steps on one thread of several (see AdaptiveThreadCount)
  int splits = 0, layouts = 0;                   // split vertices, and how often the solver was rebuilt for them
  double layout_seconds = 0;                     // time of these rebuilds
  std::int64_t most_crossings = 0;               // the largest count of all checks
  std::int64_t crossings_counted = 0;            // number of checks
  LargestStrains strains;                        // of the steps since this run started or was resumed
  std::vector<Launches> launches;                // of the first step, by kernel in the order of their first launches
};

/// Returns the median duration of a step, ms; 0 without steps.
double median_step_ms(const RunTimes& times);

/// Numbers with names, in the order in which they are shown.
using NamedNumbers = std::vector<std::pair<std::string, double>>;

/// Returns the durations (s) of the parts of set-up: load, order, build_constraints, patches, colour, layout,
/// collision, and levels and filter where there are any.
NamedNumbers setup_parts(const Model& model, const SolverStats& facts);

/// Returns memory by owner, in bytes: particles, constraints, patches (with the fast memory of patch solves), collision
/// without Embree's own memory, the model, and levels where there are any.
NamedNumbers memory_parts(const Model& model, const SolverStats& facts);

/// Returns the peak resident memory of this process, MiB.
double peak_memory_mib();

/// Returns the report's measures of the present state as JSON.
std::string measures_json(const Model& model, const Solver& solver, const RunTimes& times);

/// Returns the report as JSON with snake_case names and units as suffixes. `status`: "finished", "interrupted" or
/// "diverged"; a diverged state is not measured. `input` holds the scene with every value spelled out, and with paths
/// relative to `folder`, where the report will lie. `notes`: where the run diverged, or which expectations are not met.
std::string report_json(const std::string& status, const std::vector<std::string>& notes, const Model& model,
                        const Solver& solver, int threads, const RunTimes& times, const std::string& folder);

}  // namespace malha
