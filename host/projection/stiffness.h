// SPDX-License-Identifier: Apache-2.0
// Stiffness that does not depend on how often a constraint is projected.
#pragma once
#include <cmath>

#include "malha/scene.h"

namespace malha {

/// k' = 1 - (1 - k)^(1/n): n projections leave (1 - k) of the error (Müller et al. 2006, section 3.3).
inline double stiffness_per_projection(double k, double projections) { return 1 - std::pow(1 - k, 1.0 / projections); }

/// Projections of a batched constraint in an iteration, a forward and a backward sweep.
inline constexpr int kSweepsPerIteration = 2;

/// Stiffness k' of one projection of a PBD constraint of stiffness k. k is that of all projections of a step or, with
/// stiffness_of_step, k is converted first: the iterations of a substep then have k / (k + n^2 (1 - k)) together. A
/// step of one substep with stiffness k is backward Euler of a spring, k = s / (s + alpha / dt^2) with s = sum w |grad
/// C|^2; the conversion gives the same spring with n substeps. `projections`: number in an iteration.
inline double stiffness_per_projection(double k, const SolverSpec& solver, int projections) {
  const double n = solver.substeps;
  if (!solver.stiffness_of_step) return stiffness_per_projection(k, n * solver.iterations * projections);
  return stiffness_per_projection(k / (k + n * n * (1 - k)), double(solver.iterations) * projections);
}

}  // namespace malha
