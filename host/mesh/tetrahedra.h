// SPDX-License-Identifier: Apache-2.0
// Checks and completion of tetrahedral meshes, for their readers and shapes.
#pragma once
#include <string>

#include "malha/mesh.h"

namespace malha {

/// The signed volume (p1 - p0) . ((p2 - p0) x (p3 - p0)) / 6, m^3. It is positive if (p0, p1, p2) is counter-clockwise
/// seen from p3.
double volume(const std::vector<Vec3>& points, const Tetrahedron& tetrahedron);

/// Completes a mesh with tetrahedra: swaps the last two corners of those with a negative volume, and replaces the faces
/// by the surface: the triangles that belong to one tetrahedron only, counter-clockwise seen from outside, in the order
/// of the tetrahedra. Does nothing without tetrahedra. Throws InputError, with numbers from 0, for a tetrahedron with
/// equal corners, a volume of at most 1e-6 of the cube of the longest edge, a triangle of more than two tetrahedra, and
/// two tetrahedra on the same side of a triangle.
void complete_tetrahedra(Mesh& mesh, const std::string& file);

}  // namespace malha
