// SPDX-License-Identifier: Apache-2.0
// Reading of mesh files.
#pragma once
#include <string>
#include <string_view>

#include "malha/mesh.h"

namespace malha {

/// Reads a mesh file by its extension in upper or lower case: OBJ, PLY (ascii and both binary orders), OFF and STL
/// (ascii, binary); glTF (.glb, .gltf; needs tinygltf), of which the scene at rest (host/mesh/io/gltf.h); and with
/// tetrahedra or a surface Medit's .mesh and Gmsh's .msh (2.2 and 4.1, ASCII and both binary orders); and TetGen's
/// .node and .ele, by the path of either or their path without extension. The faces of a mesh with tetrahedra are their
/// surface, see host/mesh/tetrahedra.h. Points and faces keep the order of the file. Quads stay quads; polygons of five
/// and more corners are triangulated in their best-fit plane (host/mesh/polygons.h); faces that cross themselves are
/// refused. STL files have no shared points: corners with exactly the same position become one point, in the order of
/// first appearance. Indices are checked, the geometry is not (see host/mesh/check_mesh.h). Throws InputError, which
/// names the file, the line and column (or byte), what was found and what is allowed.
Mesh read_mesh(const std::string& path);

/// Reads the texture coordinates of an OBJ or glTF file: points (u, v, 0), and the faces that read_mesh() reads, in
/// their order, with numbers of these points. Throws InputError, also for a corner without texture coordinates.
Mesh read_texture_coordinates(const std::string& path);

/// True if the path has the extension of a format that read_mesh() reads.
bool is_mesh_file(const std::string& path);

/// True if the path has the extension of a glTF file, which may have clips.
bool is_gltf_file(const std::string& path);

/// Readers of the formats, used by read_mesh(). `file` names the input in messages, `data` is its whole content.
Mesh read_obj(const std::string& file, std::string_view data);
Mesh read_obj_texture(const std::string& file, std::string_view data);
Mesh read_off(const std::string& file, std::string_view data);
Mesh read_ply(const std::string& file, std::string_view data);
Mesh read_stl(const std::string& file, std::string_view data);
Mesh read_medit(const std::string& file, std::string_view data);
Mesh read_gmsh(const std::string& file, std::string_view data);
Mesh read_gltf(const std::string& file, std::string_view data);
Mesh read_gltf_texture(const std::string& file, std::string_view data);
Mesh read_tetgen(const std::string& node_file, std::string_view node_data, const std::string& ele_file,
                 std::string_view ele_data);

}  // namespace malha
