// SPDX-License-Identifier: Apache-2.0
// Scenes as text.
#pragma once
#include <filesystem>
#include <string>

#include "malha/scene.h"

namespace malha {

/// As to_json(scene), with paths that start from this folder, where the text will lie.
std::string to_json(const Scene& scene, const std::string& folder);

}  // namespace malha
