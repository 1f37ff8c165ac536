#include "host/mesh/mesh_io.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>

#include "host/base/file.h"
#include "host/error.h"
#include "host/mesh/mesh_formats.h"

namespace malha {
namespace {

// Four sides to a face must still be countable in an int.
constexpr std::size_t most_items = std::size_t{1} << 28;

std::string load(const std::string& path) {
  try {
    return read_whole(path);
  } catch (const std::runtime_error& error) {
    throw InputError(std::string(error.what()) + "; allowed: a readable mesh file");
  }
}

void require_countable(const std::string& path, std::size_t count, const char* items) {
  if (count > most_items) {
    refuse(path, "", std::to_string(count) + " " + items, "at most " + std::to_string(most_items));
  }
}

}  // namespace

void add_polygon(Mesh& mesh, const std::vector<int>& corners) {
  if (corners.size() == 4) {
    mesh.faces.push_back({corners[0], corners[1], corners[2], corners[3]});
    return;
  }
  for (std::size_t i = 2; i < corners.size(); ++i) mesh.faces.push_back({corners[0], corners[i - 1], corners[i], -1});
}

Mesh read_mesh(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  using Reader = Mesh (*)(const std::string&, std::string_view);
  const Reader reader = extension == ".obj"   ? read_obj
                        : extension == ".ply" ? read_ply
                        : extension == ".off" ? read_off
                        : extension == ".stl" ? read_stl
                                              : nullptr;
  if (reader == nullptr) refuse(path, "", "the extension \"" + extension + "\"", ".obj, .ply, .off or .stl");
  Mesh mesh = reader(path, load(path));
  if (mesh.points.empty()) refuse(path, "", "a mesh without vertices", "one vertex or more");
  require_countable(path, mesh.points.size(), "vertices");
  require_countable(path, mesh.faces.size(), "faces");
  require_countable(path, mesh.lines.size(), "lines");
  return mesh;
}

}  // namespace malha
