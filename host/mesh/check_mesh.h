// SPDX-License-Identifier: Apache-2.0
// Whether a mesh can be simulated as it is.
#pragma once
#include <string>

#include "malha/mesh.h"

namespace malha {

struct MeshIssues {
  int zero_area_faces = 0;  // removed, or cut down to the half that has an area
};

/// Removes what has no area and refuses what cannot be meant.
/// Removed and counted: triangles whose area is at most 1e-12 of the square of the bounding box's diagonal; quads whose
/// two halves, (0, 1, 2) and (0, 2, 3), are such, or that are folded onto themselves (opposite corners are one vertex).
/// A quad with one such half becomes the other half and is counted; if it has two good halves along its other diagonal,
/// it is only renumbered to start at its second corner, and its neighbours keep their edges. So is a concave quad whose
/// first diagonal lies outside of it.
/// Refused, by numbers that count from 0 in the mesh as given, or vertices in its file: coordinates that are not finite
/// or beyond 1e12 m; two vertices in exactly the same place; two faces of the same vertices; a line from a vertex to
/// itself; a quad two of whose sides cross; a vertex of no face, line or tetrahedron, unless loose points are allowed.
/// Throws InputError; the mesh is unchanged then.
MeshIssues check_mesh(Mesh& mesh, const std::string& file, bool loose_points_allowed);

}  // namespace malha
