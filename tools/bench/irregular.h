// SPDX-License-Identifier: Apache-2.0
// An irregular triangle mesh: what scanned and modelled clothes look like to a solver, made from numbers alone.
#pragma once
#include "malha/mesh.h"

namespace malha::bench {

/// About a square sheet of `size` m in the plane y = 0, x and z in [0, size], with side * side points (side >= 3):
/// a lattice whose points are jittered (those of the border along it), whose diagonals are chosen at random, and of
/// whose edges many are flipped where both triangles stay well-shaped. Inner points have 4 to 9 neighbours. Points
/// and triangles are shuffled; normals point to +y. The same mesh on any platform.
Mesh irregular_sheet(int side, double size);

}  // namespace malha::bench
