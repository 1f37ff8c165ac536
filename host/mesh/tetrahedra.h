// SPDX-License-Identifier: Apache-2.0
// Meshes of tetrahedra: what their readers and shapes share.
#pragma once
#include <string>

#include "malha/mesh.h"

namespace malha {

/// (p1 - p0) . ((p2 - p0) x (p3 - p0)) / 6, m^3: positive where p3 lies on the side to which (p0, p1, p2) winds
/// counter-clockwise.
double volume(const std::vector<Vec3>& points, const Tetrahedron& tetrahedron);

/// Makes a mesh with tetrahedra ready: every one with a positive volume (its last two corners change places where it
/// was negative), and as faces the surface of all: triangles that belong to one tetrahedron only, counter-clockwise
/// seen from outside, in the order of the tetrahedra. Whatever faces there were are dropped. Refuses, by numbers that
/// count from 0: a corner named twice, a volume of at most 1e-6 of the cube of the longest edge, a triangle of more
/// than two tetrahedra, two tetrahedra on the same side of a triangle. Does nothing without tetrahedra. Throws
/// InputError.
void complete_tetrahedra(Mesh& mesh, const std::string& file);

}  // namespace malha
