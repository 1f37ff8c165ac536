// SPDX-License-Identifier: Apache-2.0
// Meshes of the generated shapes, and what a scene does to a shape before it becomes a body.
#pragma once
#include "malha/mesh.h"
#include "malha/scene.h"

namespace malha {

/// The mesh of a generated shape (anything but a MeshFile), numbered as host/malha/scene.h says. All faces are
/// counter-clockwise seen from outside; a grid's normals point to +y. Points of boxes and bars: those of the lattice
/// that lie on the surface, x fastest, then y, then z. A bar has as many cells along x as come closest to squares, at
/// least one, and is centred on the x axis. A tet_box has all points of its lattice, numbered likewise, and five
/// tetrahedra a cell. A listed mesh is as it was given, its tetrahedra completed (host/mesh/tetrahedra.h). A cloud with
/// one particle along an axis has it in the middle. Throws InputError for counts below one and for meshes too large to
/// number.
Mesh generate(const Shape& shape);

/// read_mesh for a MeshFile, generate for all others.
Mesh make_mesh(const Shape& shape);

/// Moves every point x, and every vertex that nothing uses, to translate + rotate(axis, degrees) * scale * x.
void apply(const Transform& transform, Mesh& mesh);

}  // namespace malha
