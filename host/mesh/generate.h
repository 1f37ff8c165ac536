// SPDX-License-Identifier: Apache-2.0
// Meshes of generated shapes, and the transform of meshes.
#pragma once
#include "malha/mesh.h"
#include "malha/scene.h"

namespace malha {

/// The mesh of a generated shape (any but a MeshFile), numbered as host/malha/scene.h says. All faces are
/// counter-clockwise seen from outside; the normals of a grid point to +y. The points of boxes and bars are the surface
/// points of a lattice, x fastest, then y, then z. A bar has as many cells along x as make them closest to squares, at
/// least one, and is centred on the x axis. A tet_box has all points of its lattice in the same order, and five
/// tetrahedra per cell. Mesh data are taken as given, with their tetrahedra completed (host/mesh/tetrahedra.h). A
/// lattice with one particle along an axis has it in the middle. Capsules and cylinders, which are for drawing, have 32
/// points around; a plane is a square of 2 m. Throws InputError for counts below one and for meshes
/// with too many points.
Mesh generate(const Shape& shape);

/// The mesh of any shape: read_mesh() for a MeshFile, otherwise generate().
Mesh make_mesh(const Shape& shape);

/// Maps every point x, and every unused vertex, to translate + rotate(axis, degrees) * scale * x.
void apply(const Transform& transform, Mesh& mesh);

}  // namespace malha
