// SPDX-License-Identifier: Apache-2.0
// Pins that are set between two steps.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// The user's particles that are pinned for good and rest, ascending.
std::vector<int> still_pins(const Model& model);

/// Whether each particle (the user's number) has a pin or a rigid attachment on keyframes.
std::vector<bool> on_keyframes(const Model& model);

/// The model's scene, in which these particles (the user's numbers, ascending) are the pins that rest. Throws
/// InputError for one that is not there, and for one that an attachment or a pin on keyframes or with a release has.
Scene with_pins(const Model& model, const std::vector<int>& particles);

}  // namespace malha
