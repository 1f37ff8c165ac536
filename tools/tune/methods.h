// SPDX-License-Identifier: Apache-2.0
// Methods that malha tune tries on a scene, each with the substeps that it needs.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha::tuning {

/// Returns the scene by every method that it allows, in float, cheap ones first, so that expensive ones are abandoned
/// early. `left_out` gets a line for each method that the scene excludes.
std::vector<Scene> tune_methods(const Scene& scene, std::vector<std::string>& left_out);

/// Returns the same scene by PBD, with springs of Desbrun's method as constraints of the same compliance. `why` gets
/// the reason if some have no such counterpart.
Scene to_pbd(const Scene& scene, std::string& why);

/// Returns the name of a scene's method: "XPBD, 4 iterations, double", "PBD, 1 iteration, levels, float", "Desbrun,
/// sparse, refine 4, float".
std::string method_name(const Scene& scene);

}  // namespace malha::tuning
