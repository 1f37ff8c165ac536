// Stiffness that does not depend on how often a constraint is projected.
#pragma once
#include <cmath>

namespace malha {

/// k' = 1 - (1 - k)^(1/n): n projections leave (1 - k) of the error (Müller et al. 2006, section 3.3).
inline double stiffness_per_projection(double k, double projections) { return 1 - std::pow(1 - k, 1.0 / projections); }

}  // namespace malha
