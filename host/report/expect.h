// SPDX-License-Identifier: Apache-2.0
// Checks of a state against the expectations of its scene.
#pragma once
#include <string>
#include <vector>

#include "malha/measures.h"
#include "malha/mesh.h"
#include "malha/scene.h"

namespace malha {

/// A body's particles: first .. end - 1 of all particles in the user's order.
struct ParticlesOfBody {
  std::string name;
  std::size_t first, end;
  FileVertices vertices{};
};

/// Returns a line for every expectation that is not met, with the found and the allowed value. Positions that are not
/// finite always give a line. `bodies` must include those that expect.bodies names.
std::vector<std::string> unmet_expectations(const Expect& expect, const Measures& measures,
                                            const std::vector<Vec3>& positions,
                                            const std::vector<ParticlesOfBody>& bodies = {});

}  // namespace malha
