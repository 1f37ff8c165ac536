// SPDX-License-Identifier: Apache-2.0
// Softening of compliant sheets by projections that do not converge within a substep.
#pragma once
#include <string>

#include "host/model/model.h"

namespace malha {

/// Excess deformation of a compliant sheet, relative to its material. One sweep solves a constraint only where its
/// compliance alpha dominates, that is where s = h^2 sum w |grad C|^2 / alpha is small; what neighbours undo of the
/// rest is lost. At rest the sheet deforms by s / 2 (hinges, membranes) or 0.7 s (plates) more, where s is the median
/// of a body's constraints. Measured on sagging and hanging strips of 8 to 32 cells, grids and irregular triangles:
/// 0.28 to 0.54 s and 0.42 to 0.85 s where s is below 1. The springs of a balloon that a compliant pressure inflates
/// deform by 0.56 to 0.66 s more (spheres of 162 to 2,562 particles, s from 0.2 to 14); other springs are not judged. n
/// iterations reduce it to an n^2-th, or less.
struct Softening {
  double share = 0;
  int body = 0;
  std::string type;
};
/// Returns the softening of the worst body by what is projected; 0 by Desbrun's method, and without such constraints.
Softening worst_softening(const Model& model);

/// Dimensionless numbers of a substep of bending, by one set of constraints.
struct BendingStep {
  double s = 0, softening = 0;  // softening: if it is projected; both 0 for other kinds, and without compliance
  /// If it is filtered: sqrt(s) times the fold at rest (rad), RMS of the constraints, so that the few folds of a box
  /// count too. In the filter folds keep their directions for a substep, and turn with the body as a whole only.
  double turning = 0;
};
/// The turning up to which a filtered shell gains no energy on impact. Measured on irregular closed meshes of 162
/// particles that fall, over seven decades of stiffness: up to 4 they stay below twice the speed of their fall, at 12
/// some reach 17 times that, and from 40 on they explode.
inline constexpr double kMostTurning = 4;
/// The s up to which a filter in float can be used, and up to which it is exact. Rounded places of a stiff sheet move
/// it by some 1e-7 s of its size in a substep: one of s = 1e6 sagged by 4 % less than in double, those of 1e7 and more
/// diverge.
inline constexpr double kMostInFloat = 3e6, kExactInFloat = 3e5;
BendingStep bending_step(const Model& model, const ConstraintSet& set);

}  // namespace malha
