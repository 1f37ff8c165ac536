// SPDX-License-Identifier: Apache-2.0
// How soft too few substeps make the bending and the membranes of sheets.
#pragma once
#include <string>

#include "host/model/model.h"

namespace malha {

/// By what share a compliant sheet gives way more than was asked for. One sweep meets a constraint as far as its
/// compliance alpha outweighs s = h^2 sum w |grad C|^2 / alpha, and what neighbours undo of that is lost: at rest the
/// sheet gives way more by s / 2 (hinges, membranes) or 0.7 s (plates), with s the median of a body's constraints.
/// Measured on sagging and hanging strips of 8 to 32 cells, grids and irregular triangles: 0.28 to 0.54 s and 0.42 to
/// 0.85 s where s is below 1. The springs of a balloon that a compliant pressure blows up give way by 0.56 to 0.66 s
/// more (spheres of 162 to 2,562 particles, s from 0.2 to 14); other springs are not judged. n iterations make it an
/// n^2-th, or less.
struct Softening {
  double share = 0;
  int body = 0;
  std::string type;
};
/// That of the worst body; 0 by Desbrun's method, and without such constraints.
Softening worst_softening(const Model& model);

}  // namespace malha
