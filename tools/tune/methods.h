// SPDX-License-Identifier: Apache-2.0
// The methods that malha tune tries on a scene, each of which gets as many substeps as it needs.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

/// The scene by every method that it allows, in float, cheap ones first, so that dear ones are given up early.
/// `left_out` gets a line for each method that the scene rules out.
std::vector<Scene> tune_methods(const Scene& scene, std::vector<std::string>& left_out);

/// The same scene by PBD: springs of Desbrun's method become constraints of the same compliance. Says in `why` what
/// has no such counterpart, if anything.
Scene by_pbd(const Scene& scene, std::string& why);

/// A scene's method in words: "XPBD, 4 iterations, double", "PBD, 1 iteration, levels, float", "Desbrun, sparse, refine
/// 4, float".
std::string words_of(const Scene& scene);

}  // namespace malha::study
