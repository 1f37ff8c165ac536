// SPDX-License-Identifier: Apache-2.0
// The folds in which sheets hang, compared with the edges of their meshes.
#pragma once
#include "host/model/model.h"

namespace malha {

/// A sheet that hangs from a clamp, or over a line of pins, turns into the direction of gravity over a length of
/// sqrt(D / T): D its rigidity, T the weight that hangs there, in N/m. Where that spans fewer than two edges the hinges
/// there turn by angles that no plate does: a heavy elastica's drop over reach is 13 % off with 0.7 edges, and 70 %
/// where a compliance clamps it half a cell inside.
struct HangingFold {
  double length = 0;   // sqrt(D / T), m
  double spacing = 0;  // of the mesh across the fold there, m
  int body = 0;
  double edges() const { return length / spacing; }
};
/// The one that spans the fewest edges; without any, `spacing` is 0. Where the sheet leaves its clamp or line within 30
/// degrees of the direction of gravity it has no fold, and nor has one whose bending is not that of a material.
HangingFold sharpest_fold(const Model& model);

}  // namespace malha
