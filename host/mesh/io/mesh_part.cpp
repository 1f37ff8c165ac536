// SPDX-License-Identifier: Apache-2.0
// Selection of an object or a group of a mesh file.
#include <algorithm>
#include <string>
#include <vector>

#include "host/base/spelling_suggestion.h"
#include "host/mesh/io/mesh_io.h"
#include "malha/error.h"

namespace malha {

namespace {

/// True if a line of names is the name, or has it among its words.
bool has_name(const std::string& line, const std::string& name) {
  if (line == name) return true;
  const std::string words = " " + line + " ";
  return words.find(" " + name + " ") != std::string::npos;
}

/// Marks the names that are asked for; an empty list if all are. Throws InputError if there are none.
template <class Matches>
std::vector<bool> marked(const std::vector<std::string>& names, const std::string& wanted, const std::string& what,
                         const std::string& path, const Matches& matches) {
  if (wanted.empty()) return {};
  std::vector<bool> all;
  for (const std::string& name : names) all.push_back(matches(name, wanted));
  if (std::ranges::count(all, true) == 0)
    refuse(path, "", "no " + what + " '" + wanted + "'" + did_you_mean(wanted, names),
           names.empty() ? "a file that names its " + what + "s" : "one of: " + join(names));
  return all;
}

bool is_wanted(const std::vector<bool>& wanted, int name) {
  return wanted.empty() || (name >= 0 && wanted[static_cast<std::size_t>(name)]);
}

/// Keeps the items of the list, which has none or one for each mark, that are marked.
template <class T>
void keep(std::vector<T>& list, const std::vector<bool>& marks) {
  std::size_t left = 0;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (marks[i]) list[left++] = std::move(list[i]);
  list.resize(left);
}

}  // namespace

std::vector<int> select_part(FileMesh& file, const MeshPart& part, const std::string& path) {
  Mesh& mesh = file.mesh;
  Polygons& all = file.polygons;
  const auto objects = marked(all.objects, part.object, "object", path, std::equal_to<>());
  const auto groups = marked(all.groups, part.group, "group", path, has_name);

  enum class Use { None, Other, Wanted };
  std::vector<Use> use(mesh.points.size(), Use::None);
  const auto mark = [&use](const auto& corners, bool is_wanted) {
    for (const int v : corners) {
      Use& of = use[static_cast<std::size_t>(v)];
      if (of != Use::Wanted) of = is_wanted ? Use::Wanted : Use::Other;
    }
  };
  const auto is_part = [&](const std::vector<int>& object, const std::vector<int>& group, std::size_t i) {
    return is_wanted(objects, object.empty() ? -1 : object[i]) && is_wanted(groups, group.empty() ? -1 : group[i]);
  };
  std::vector<bool> polygons, lines;
  for (std::size_t f = 0; f < all.count(); ++f) {
    polygons.push_back(is_part(all.object, all.group, f));
    mark(all.corners_of(f), polygons[f]);
  }
  for (std::size_t i = 0; i < mesh.lines.size(); ++i) {
    lines.push_back(is_part(all.line_object, all.line_group, i));
    mark(mesh.lines[i], lines[i]);
  }
  if (groups.empty())
    for (std::size_t v = 0; v < use.size(); ++v)
      if (use[v] == Use::None && is_wanted(objects, all.vertex_object[v])) use[v] = Use::Wanted;

  std::vector<int> vertices, number(use.size(), -1);
  for (std::size_t v = 0; v < use.size(); ++v) {
    if (use[v] != Use::Wanted) continue;
    number[v] = static_cast<int>(vertices.size());
    vertices.push_back(static_cast<int>(v));
    mesh.points[vertices.size() - 1] = mesh.points[v];
    if (!all.vertex_object.empty()) all.vertex_object[vertices.size() - 1] = all.vertex_object[v];
    if (!file.colours.empty()) file.colours[vertices.size() - 1] = file.colours[v];
  }
  mesh.points.resize(vertices.size());
  if (!all.vertex_object.empty()) all.vertex_object.resize(vertices.size());
  if (!file.colours.empty()) file.colours.resize(vertices.size());

  keep(mesh.lines, lines), keep(all.line_object, lines), keep(all.line_group, lines);
  for (Edge& line : mesh.lines) line = {number[line[0]], number[line[1]]};
  Polygons left;
  for (std::size_t f = 0; f < all.count(); ++f) {
    if (!polygons[f]) continue;
    std::vector<int> corners;
    for (const int v : all.corners_of(f)) corners.push_back(number[static_cast<std::size_t>(v)]);
    left.add(corners);
    if (!all.corner_uv.empty())
      left.corner_uv.insert(left.corner_uv.end(), all.corner_uv.begin() + all.begin[f],
                            all.corner_uv.begin() + all.begin[f + 1]);
  }
  all.begin = std::move(left.begin), all.corners = std::move(left.corners), all.corner_uv = std::move(left.corner_uv);
  keep(all.line, polygons), keep(all.object, polygons), keep(all.group, polygons), keep(all.material, polygons);
  return vertices;
}

}  // namespace malha
