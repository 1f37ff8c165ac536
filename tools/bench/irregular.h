// SPDX-License-Identifier: Apache-2.0
// Generator of irregular triangle meshes, which resemble those of scanned and modelled clothes.
#pragma once
#include "malha/mesh.h"

namespace malha::bench {

/// A square sheet of `size` m in the plane y = 0, x and z in [0, size], with side * side points (side >= 3): a lattice
/// whose points are jittered (those of the border along it), whose diagonals are chosen at random, and many of whose
/// edges are flipped where both triangles stay well-shaped. Inner points have 4 to 9 neighbours. Points and triangles
/// are shuffled; normals point to +y. The mesh is the same on every platform.
Mesh irregular_sheet(int side, double size);

}  // namespace malha::bench
