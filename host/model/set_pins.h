// SPDX-License-Identifier: Apache-2.0
// Changes of the pins between two steps.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// The particles that are pinned permanently and at rest, in the user's numbering, ascending.
std::vector<int> static_pins(const Model& model);

/// Tells whether each particle (the user's numbering) has a pin or a rigid attachment that moves.
std::vector<bool> has_keyframes(const Model& model);

/// The scene of the model with these particles (the user's numbering, ascending) as its static pins. Throws InputError
/// for an index out of range, and for a particle of a rigid attachment or of a pin with keyframes or a release time.
Scene with_pins(const Model& model, const std::vector<int>& particles);

}  // namespace malha
