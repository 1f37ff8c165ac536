// SPDX-License-Identifier: Apache-2.0
// Meshes from files.
#pragma once
#include <string>

#include "malha/mesh.h"

namespace malha {

/// Reads a mesh by its extension, whatever its case: OBJ, PLY (ascii and both binary orders), OFF, STL (ascii, binary),
/// and with tetrahedra Medit's .mesh and Gmsh's .msh (2.2 and 4.1, ASCII and both binary orders), which may hold a
/// surface instead, and TetGen's .node and .ele, by the path of either or by what they have in common. A mesh with
/// tetrahedra has their surface as faces, see host/mesh/tetrahedra.h. Points keep the file's order, faces too; quads
/// stay quads, polygons of five and more corners are triangulated in their best plane (host/mesh/polygons.h), and faces
/// that cross themselves are refused. STL names no shared points: corners at exactly the same place become one, in the
/// order of first appearance. Indices are checked; geometry is not (see host/mesh/check_mesh.h). Throws InputError
/// naming the file, the line and column (or byte), what was found and what is allowed.
Mesh read_mesh(const std::string& path);

/// Whether the path has the extension of a format that read_mesh reads.
bool is_mesh_file(const std::string& path);

}  // namespace malha
