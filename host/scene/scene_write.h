// SPDX-License-Identifier: Apache-2.0
// Writer of scenes as JSON.
#pragma once
#include <filesystem>
#include <string>

#include "malha/scene.h"

namespace malha {

/// to_json(scene) with mesh paths relative to `folder`, in which the text will be stored.
std::string to_json(const Scene& scene, const std::string& folder);

}  // namespace malha
