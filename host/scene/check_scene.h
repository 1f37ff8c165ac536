// SPDX-License-Identifier: Apache-2.0
// Validation of scenes that were made or changed in code, by the rules for scene files.
#pragma once
#include "malha/scene.h"

namespace malha {

/// Throws the InputError that parse_scene() would throw for the JSON of the scene.
void check_scene(const Scene& scene);

}  // namespace malha
