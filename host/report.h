// report.json: what was run, on what, how fast and how well.
#pragma once
#include <string>
#include <vector>

#include "host/model.h"
#include "host/solver.h"

namespace malha {

struct RunTimes {
  double model_seconds = 0, solver_seconds = 0;  // set-up
  std::vector<double> step_seconds;              // one a step
};

/// JSON with snake_case names and the unit as suffix. `status`: "finished", "interrupted" or "diverged"; a diverged
/// state is not measured.
std::string report_json(const std::string& status, const Model& model, const Solver& solver, int threads,
                        const RunTimes& times);

}  // namespace malha
