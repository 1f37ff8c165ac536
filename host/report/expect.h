// SPDX-License-Identifier: Apache-2.0
// Whether a state is what its scene expects.
#pragma once
#include <string>
#include <vector>

#include "malha/measures.h"
#include "malha/mesh.h"
#include "malha/scene.h"

namespace malha {

/// A body's particles, first .. end - 1 of all in the user's order.
struct ParticlesOfBody {
  std::string name;
  std::size_t first, end;
  FileVertices vertices{};
};

/// A line for every expectation that is not met: what was found and what is allowed. Positions that are not finite
/// are always unmet. `bodies`: those that expect.bodies name, at least.
std::vector<std::string> unmet_expectations(const Expect& expect, const Measures& measures,
                                            const std::vector<Vec3>& positions,
                                            const std::vector<ParticlesOfBody>& bodies = {});

}  // namespace malha
