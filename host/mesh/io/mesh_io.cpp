// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/io/mesh_io.h"

#include <filesystem>
#include <type_traits>
#include <utility>

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

using Reader = FileMesh (*)(const std::string&, std::string_view, Attributes);

/// The reader of a format without attributes, or with triangles or tetrahedra.
template <auto kRead>
FileMesh read_bare(const std::string& file, std::string_view data, Attributes) {
  if constexpr (std::is_same_v<decltype(kRead(file, data)), Mesh>)
    return {kRead(file, data)};
  else
    return kRead(file, data);
}

Reader reader_of(const std::string& extension) {
  return extension == ".obj"    ? read_obj
         : extension == ".ply"  ? read_ply
         : extension == ".off"  ? read_bare<read_off>
         : extension == ".stl"  ? read_bare<read_stl>
         : extension == ".mesh" ? read_bare<read_medit>
         : extension == ".msh"  ? read_bare<read_gmsh>
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

FileMesh read_file_mesh(const std::string& path, const MeshPart& part, Attributes attributes) {
  const std::string extension = extension_of(path);
  const Reader reader = reader_of(extension);
  const bool pair =
      is_of_pair(extension) ||
      (reader == nullptr && (std::filesystem::exists(path + ".node") || std::filesystem::exists(path + ".ele")));
  if (reader == nullptr && !pair)
    refuse(path, "", "the extension \"" + extension + "\"",
           ".obj, .ply, .off, .stl, .glb or .gltf, or with tetrahedra .mesh, .msh, .node or .ele");
  if (part && extension != ".obj" && !is_gltf_file(path))
    refuse(path, "", "an object or a group of a file with the extension \"" + extension + "\"", ".obj, .glb or .gltf");
  FileMesh file = pair ? FileMesh{read_pair(path)} : reader(path, load(path), part ? Attributes::All : attributes);
  if (file.mesh.points.empty()) refuse(path, "", "a mesh without vertices", "one vertex or more");
  if (part) select_part(file, part, path);
  return file;
}

Mesh read_mesh(const std::string& path, const MeshPart& part) {
  FileMesh file = read_file_mesh(path, part, Attributes::None);
  Mesh& mesh = file.mesh;
  add_faces(file.polygons, mesh, path);
  require_countable(path, mesh.points.size(), "vertices");
  require_countable(path, mesh.faces.size(), "faces");
  require_countable(path, mesh.lines.size(), "lines");
  require_countable(path, mesh.tetrahedra.size(), "tetrahedra");
  complete_tetrahedra(mesh, path);
  return std::move(mesh);
}

Mesh read_texture_coordinates(const std::string& path, const MeshPart& part) {
  const std::string extension = extension_of(path);
  if (extension != ".obj" && !is_gltf_file(path))
    refuse(path, "", "texture coordinates of a file with the extension \"" + extension + "\"", ".obj, .glb or .gltf");
  FileMesh file = read_file_mesh(path, part, Attributes::Texture);
  const Polygons& polygons = file.polygons;
  if (polygons.uv.empty())
    refuse(path, "", "no texture coordinates",
           extension == ".obj" ? "a file with \"vt\" lines, and a number of one at each corner"
                               : "TEXCOORD_0 of all vertices");
  require_countable(path, polygons.uv.size(), "texture coordinates");
  std::vector<Quad> in_corners;
  add_faces(polygons, file.mesh, path, &in_corners);
  Mesh texture;
  for (const auto& [u, v] : polygons.uv) texture.points.push_back({u, v, 0});
  for (std::size_t f = 0; f < in_corners.size(); ++f) {
    Quad& face = texture.faces.emplace_back(Quad{-1, -1, -1, -1});
    for (int k = 0; k < 4; ++k) {
      if (in_corners[f][k] < 0) continue;
      face[k] = polygons.corner_uv[static_cast<std::size_t>(in_corners[f][k])];
      if (face[k] < 0)
        refuse(path, "face " + std::to_string(f) + " (0-based)", "a corner without texture coordinates",
               "texture coordinates at each corner, such as 7/1");
    }
  }
  return texture;
}

}  // namespace malha
