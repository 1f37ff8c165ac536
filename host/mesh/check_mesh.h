// SPDX-License-Identifier: Apache-2.0
// Checks of meshes before they are simulated, and removal of faces without area.
#pragma once
#include <string>

#include "malha/mesh.h"

namespace malha {

/// Removes faces without area and refuses invalid meshes. Returns the number of faces that were removed, or reduced to
/// the half with an area.
///
/// It removes and counts triangles whose area is at most 1e-12 of the square of the bounding box's diagonal, and quads
/// whose two halves, (0, 1, 2) and (0, 2, 3), are such triangles or whose opposite corners are the same vertex. A quad
/// with one such half becomes the other half and is counted. If its halves along the other diagonal both have an area,
/// it is instead renumbered to start at its second corner, so that its neighbours keep their edges; so is a concave
/// quad whose first diagonal lies outside of it.
///
/// It refuses coordinates that are not finite or beyond 1e12 m, two vertices with exactly the same position, two faces
/// of the same vertices, a line from a vertex to itself, a quad two of whose sides cross, and, unless loose points are
/// allowed, a vertex that no face, line or tetrahedron uses. Messages number faces and lines from 0 in the mesh as
/// given, and vertices as the file does. Throws InputError; then the mesh is unchanged.
int check_mesh(Mesh& mesh, const std::string& file, bool loose_points_allowed);

}  // namespace malha
