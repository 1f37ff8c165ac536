// SPDX-License-Identifier: Apache-2.0
// Scenes made in code, or changed after they were read, are held to what a file is held to.
#pragma once
#include "malha/scene.h"

namespace malha {

/// Throws the InputError that parse_scene would throw for its JSON.
void check_scene(const Scene& scene);

}  // namespace malha
