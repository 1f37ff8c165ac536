// SPDX-License-Identifier: Apache-2.0
// What a step would launch, pass by pass.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/solver/solver.h"

namespace malha {

struct PassOfAStep {
  std::string name;
  std::size_t launches = 0;
  std::string remark = {};  // what is launched beside them, for people; may be empty
  bool at_least = false;
};

/// Those that exist in this scene, in the order of a step.
std::vector<PassOfAStep> passes_of_a_step(const Model& model, const SolverStats& facts);

/// Particles.
std::size_t pinned_at_start(const Model& model);

}  // namespace malha
