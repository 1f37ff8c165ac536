// How iterations share the work of a constraint.
#pragma once
#include <cmath>

#include "host/scene.h"

namespace malha {

/// k' = 1 - (1 - k)^(1/n): n projections leave (1 - k) of the error (Müller et al. 2006, section 3.3).
inline double stiffness_per_projection(double k, double projections) { return 1 - std::pow(1 - k, 1.0 / projections); }

/// Projections of a batched constraint in an iteration, which goes there and back.
inline constexpr int kThereAndBack = 2;

/// What a projection takes of a PBD constraint of stiffness k: shared by all projections of a step, or, where k is that
/// of a step, by the iterations of a substep, which take k / (k + n^2 (1 - k)). A step of one substep that takes k is
/// backward Euler of a spring, k = s / (s + alpha / dt^2) with s = sum w |grad C|^2; that is the same spring's for n.
/// `projections`: of an iteration.
inline double stiffness_per_projection(double k, const SolverSpec& solver, int projections) {
  const double n = solver.substeps;
  if (!solver.stiffness_of_step) return stiffness_per_projection(k, n * solver.iterations * projections);
  return stiffness_per_projection(k / (k + n * n * (1 - k)), double(solver.iterations) * projections);
}

/// Whether projections go along the gradients where the substep began (kernels/direction.h). A direction that stays
/// does not answer to the tension across it, which one iteration hardly reaches and several do: what is taut would then
/// be shaken by what holds it, pinned sheets by 30 m/s and hung cloths to more energy than they had.
inline bool goes_from_start(const SolverSpec& solver) { return solver.iterations == 1; }

}  // namespace malha
