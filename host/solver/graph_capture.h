// SPDX-License-Identifier: Apache-2.0
// Whether every step of a model has the same launches, so that a device can capture it as a graph.
#pragma once
#include <algorithm>
#include <string>

#include "host/base/launch_graph.h"
#include "host/model/model.h"

namespace malha {

/// Tells whether all steps have the same launches without interaction: no search for contacts, nothing that depends on
/// time, and no decision by the host within a step.
inline bool can_capture_step(const Model& model) {
  const DesbrunSpec& desbrun = model.scene.solver.desbrun;
  const auto stays = [](const AttachmentSet& set) { return set.target.motion.empty() && !set.release_time; };
  return model.environment.empty() && !model.scene.self_collision && model.moved.empty() && !desbrun.tolerance &&
         !desbrun.time_budget && std::ranges::all_of(model.attached, stays);
}

/// Key of the parameters of those launches that may change between steps.
inline std::string steady_key(const Scene& scene) {
  const Wind wind = scene.wind.value_or(Wind{});
  return key_from(scene.gravity, wind.velocity, wind.drag, wind.density, wind.drag_coefficient, wind.lift_coefficient);
}

}  // namespace malha
