// SPDX-License-Identifier: Apache-2.0
// Reading of mesh files.
#pragma once
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "host/mesh/polygons.h"
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
/// It reads a whole file of several objects or groups, or a part of it. The vertices of an object are those that its
/// elements use, and those in its part of the file that no other object uses; of a group, those that it uses.
Mesh read_mesh(const std::string& path, const MeshPart& part = {});

/// The attributes that a reader reads of polygons besides their corners.
enum class Attributes { None, Texture, All };

/// The contents of a file: the faces are polygons, or in formats of triangles or tetrahedra those of the mesh.
struct FileMesh {
  Mesh mesh{};
  Polygons polygons{};
  /// Colours of the vertices as the file has them: red, green, blue, alpha, in [0, 1]. Empty: it has none, or they are
  /// not read.
  std::vector<std::array<float, 4>> colours{};
};

/// Reads a file or a part of it as it is, by its vertices, with what OBJ and glTF say of polygons. Throws InputError.
FileMesh read_file_mesh(const std::string& path, const MeshPart& part, Attributes attributes);

/// Reads the texture coordinates of an OBJ or glTF file: points (u, v, 0), and the faces that read_mesh() reads, in
/// their order, with numbers of these points. Throws InputError, also for a corner without texture coordinates.
Mesh read_texture_coordinates(const std::string& path, const MeshPart& part = {});

/// True if the path has the extension of a format that read_mesh() reads.
bool is_mesh_file(const std::string& path);

/// True if the path has the extension of a glTF file, which may have clips.
bool is_gltf_file(const std::string& path);

/// Leaves the part of a file that is asked for. Returns the vertices that are left, ascending. Throws InputError for a
/// part that the file does not have.
std::vector<int> select_part(FileMesh& file, const MeshPart& part, const std::string& path);

/// Readers of the formats, used by read_mesh(). `file` names the input in messages, `data` is its whole content.
FileMesh read_obj(const std::string& file, std::string_view data, Attributes attributes);
FileMesh read_off(const std::string& file, std::string_view data);
FileMesh read_ply(const std::string& file, std::string_view data, Attributes attributes);
FileMesh read_gltf(const std::string& file, std::string_view data, Attributes attributes);
Mesh read_stl(const std::string& file, std::string_view data);
Mesh read_medit(const std::string& file, std::string_view data);
Mesh read_gmsh(const std::string& file, std::string_view data);
Mesh read_tetgen(const std::string& node_file, std::string_view node_data, const std::string& ele_file,
                 std::string_view ele_data);

}  // namespace malha
