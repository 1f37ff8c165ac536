// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/io/mesh_io.h"

#include <filesystem>

#include "host/base/file.h"
#include "host/base/spelling_suggestion.h"
#include "host/mesh/tetrahedra.h"
#include "malha/error.h"

namespace malha {
namespace {

// The sides of all faces, four for each, must be countable in an int.
constexpr std::size_t most_items = std::size_t{1} << 28;

std::string load(const std::string& path) { return read_input(path, "a readable mesh file"); }

void require_countable(const std::string& path, std::size_t count, const char* items) {
  if (count > most_items) {
    refuse(path, "", std::to_string(count) + " " + items, "at most " + std::to_string(most_items));
  }
}

/// Reads TetGen's pair of files, given the path of either or their path without extension.
Mesh read_pair(const std::string& path) {
  std::filesystem::path node(path), ele(path);
  const std::string extension = node.extension().string();
  if (lower(extension) == ".ele") {
    node.replace_extension(extension == ".ELE" ? ".NODE" : ".node");
  } else if (lower(extension) == ".node") {
    ele.replace_extension(extension == ".NODE" ? ".ELE" : ".ele");
  } else {
    node += ".node", ele += ".ele";
  }
  const std::string points = load(node.string()), tetrahedra = load(ele.string());
  return read_tetgen(node.string(), points, ele.string(), tetrahedra);
}

std::string extension_of(const std::string& path) { return lower(std::filesystem::path(path).extension().string()); }

using Reader = Mesh (*)(const std::string&, std::string_view);
Reader reader_of(const std::string& extension) {
  return extension == ".obj"    ? read_obj
         : extension == ".ply"  ? read_ply
         : extension == ".off"  ? read_off
         : extension == ".stl"  ? read_stl
         : extension == ".mesh" ? read_medit
         : extension == ".msh"  ? read_gmsh
         : extension == ".glb"  ? read_gltf
         : extension == ".gltf" ? read_gltf
                                : nullptr;
}
bool is_of_pair(const std::string& extension) { return extension == ".node" || extension == ".ele"; }

}  // namespace

bool is_mesh_file(const std::string& path) {
  const std::string extension = extension_of(path);
  return reader_of(extension) != nullptr || is_of_pair(extension);
}

bool is_gltf_file(const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".glb" || extension == ".gltf";
}

Mesh read_mesh(const std::string& path) {
  const std::string extension = extension_of(path);
  const Reader reader = reader_of(extension);
  const bool pair =
      is_of_pair(extension) ||
      (reader == nullptr && (std::filesystem::exists(path + ".node") || std::filesystem::exists(path + ".ele")));
  if (reader == nullptr && !pair)
    refuse(path, "", "the extension \"" + extension + "\"",
           ".obj, .ply, .off, .stl, .glb or .gltf, or with tetrahedra .mesh, .msh, .node or .ele");
  Mesh mesh = pair ? read_pair(path) : reader(path, load(path));
  if (mesh.points.empty()) refuse(path, "", "a mesh without vertices", "one vertex or more");
  require_countable(path, mesh.points.size(), "vertices");
  require_countable(path, mesh.faces.size(), "faces");
  require_countable(path, mesh.lines.size(), "lines");
  require_countable(path, mesh.tetrahedra.size(), "tetrahedra");
  complete_tetrahedra(mesh, path);
  return mesh;
}

Mesh read_texture_coordinates(const std::string& path) {
  const std::string extension = extension_of(path);
  const Reader reader = extension == ".obj"                           ? read_obj_texture
                        : extension == ".glb" || extension == ".gltf" ? read_gltf_texture
                                                                      : nullptr;
  if (!reader)
    refuse(path, "", "texture coordinates of a file with the extension \"" + extension + "\"", ".obj, .glb or .gltf");
  Mesh texture = reader(path, load(path));
  require_countable(path, texture.points.size(), "texture coordinates");
  return texture;
}

}  // namespace malha
