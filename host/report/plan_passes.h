// SPDX-License-Identifier: Apache-2.0
// Launches of a step by pass, predicted before it runs.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/solver/solver.h"

namespace malha {

struct StepPass {
  std::string name;
  std::size_t launches = 0;
  std::string remark = {};  // which further launches there may be, in words; may be empty
};

/// Returns the passes of this scene in the order of a step.
std::vector<StepPass> step_passes(const Model& model, const Solver& solver);

/// Returns the number of particles that are pinned at the start.
std::size_t pinned_at_start(const Model& model);

}  // namespace malha
