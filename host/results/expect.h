// Whether a state is what its scene expects.
#pragma once
#include <string>
#include <vector>

#include "host/measures.h"
#include "host/scene.h"

namespace malha {

/// A line for every expectation that is not met: what was found and what is allowed. Positions that are not finite
/// are always unmet.
std::vector<std::string> unmet_expectations(const Expect& expect, const Measures& measures,
                                            const std::vector<Vec3>& positions);

}  // namespace malha
