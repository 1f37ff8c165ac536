// SPDX-License-Identifier: Apache-2.0
// Softening of bending and membranes of sheets because of too few substeps.
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
/// Returns the softening of the worst body; 0 by Desbrun's method, and without such constraints.
Softening worst_softening(const Model& model);

}  // namespace malha
