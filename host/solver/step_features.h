// SPDX-License-Identifier: Apache-2.0
// Whether a scene has passes between prediction and state update other than its batched constraints.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Tells whether contacts with the environment are the only such passes, if there are any.
inline bool has_only_contacts(const Model& model) {
  return model.pressures.empty() && model.attached.empty() && model.long_range.items() == 0 &&
         !model.scene.self_collision;
}
inline bool has_no_mid_step_passes(const Model& model) { return model.environment.empty() && has_only_contacts(model); }

}  // namespace malha
