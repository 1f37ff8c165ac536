// SPDX-License-Identifier: Apache-2.0
// Steps that launch the same as the one before: those that a device records as a whole.
#pragma once
#include <algorithm>
#include <string>

#include "host/base/launch_graph.h"
#include "host/model/model.h"

namespace malha {

/// Whether steps of a model launch the same while nobody touches it: nothing is searched for, nothing depends on time,
/// and the host decides nothing on the way.
inline bool can_capture_step(const Model& model) {
  const DesbrunSpec& desbrun = model.scene.solver.desbrun;
  const auto stays = [](const AttachmentSet& set) { return set.target.motion.empty() && !set.release_time; };
  return model.environment.empty() && !model.scene.self_collision && model.moved.empty() && !desbrun.tolerance &&
         !desbrun.time_budget && std::ranges::all_of(model.attached, stays);
}

/// What the launches of such a step depend on, and may change between steps.
inline std::string steady_key(const Scene& scene) {
  const Wind wind = scene.wind.value_or(Wind{});
  return key_from(scene.gravity, wind.velocity, wind.drag, wind.density, wind.drag_coefficient, wind.lift_coefficient);
}

}  // namespace malha
