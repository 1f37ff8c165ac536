// SPDX-License-Identifier: Apache-2.0
#include "host/output/topology_builder.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "host/mesh/first_equal.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// The name, with a number such as .001 where another has it already. Blender numbers names alike.
std::string unique_name(const std::string& name, std::set<std::string>& names) {
  std::string unique = name;
  for (int k = 1; !names.insert(unique).second; ++k) {
    char number[16];
    std::snprintf(number, sizeof number, ".%03d", k);
    unique = name + number;
  }
  return unique;
}

/// The vertices of an object, which follow each other in the file.
struct Run {
  int object;  // the number of objects: none is named
  int begin;
};

int object_of(const Polygons& polygons, const std::vector<int>& list, std::size_t i) {
  return list.empty() || list[i] < 0 ? static_cast<int>(polygons.objects.size()) : list[i];
}

/// Divides the vertices of a file into runs of one object each. Returns one run where objects share vertices, or have
/// others between their own.
std::vector<Run> runs_of_objects(const FileMesh& file) {
  const Polygons& polygons = file.polygons;
  std::vector<int> object(file.mesh.points.size(), -1);
  bool is_shared = false;
  const auto mark = [&](const auto& corners, int name) {
    for (const int v : corners) {
      int& of = object[static_cast<std::size_t>(v)];
      is_shared = is_shared || (of >= 0 && of != name);
      of = name;
    }
  };
  for (std::size_t f = 0; f < polygons.count(); ++f)
    mark(polygons.corners_of(f), object_of(polygons, polygons.object, f));
  for (std::size_t i = 0; i < file.mesh.lines.size(); ++i)
    mark(file.mesh.lines[i], object_of(polygons, polygons.line_object, i));
  std::vector<Run> runs;
  for (std::size_t v = 0; v < object.size(); ++v) {
    if (object[v] < 0 && !polygons.vertex_object.empty()) object[v] = polygons.vertex_object[v];
    if (object[v] < 0) continue;  // it belongs to the object before, or to the first one
    if (runs.empty() || runs.back().object != object[v])
      runs.push_back({object[v], runs.empty() ? 0 : static_cast<int>(v)});
  }
  std::set<int> seen;
  for (const Run& run : runs) is_shared = is_shared || !seen.insert(run.object).second;
  if (is_shared || runs.empty()) return {{static_cast<int>(polygons.objects.size()), 0}};
  return runs;
}

}  // namespace

void TopologyBuilder::add_body(int begin, int end, const std::vector<Quad>& faces) {
  const BodySpec& spec = scene_.bodies[body_];
  Source source;
  if (const auto* shape = std::get_if<MeshFile>(&spec.shape)) {
    source.file = read_file_mesh(shape->path, shape->part, Attributes::All);
    if (source.file.polygons.count() > 0) source.path = shape->path;
    const auto vertices = static_cast<std::size_t>(end - begin);
    if (!spec.tear && !source.path.empty() && source.file.mesh.points.size() != vertices)
      refuse(source.path, "", counted(source.file.mesh.points.size(), "vertex", "vertices"),
             std::to_string(vertices) + ", as when the simulation was made");
    source.new_uv.assign(source.file.polygons.uv.size(), -1);
  }
  if (source.path.empty() || spec.tear) {
    add_mesh(spec.name, begin);
    add_faces(begin, end, faces, source);
  } else {
    add_polygons_of_file(begin, source);
  }
  ++body_;
}

void TopologyBuilder::name_environment() {
  for (const EnvironmentMesh& object : all_.environment)
    all_.environment_names.push_back(unique_name(printable(object.spec.name), mesh_names_));
}

void TopologyBuilder::add_mesh(const std::string& name, int begin) {
  all_.meshes.push_back({unique_name(printable(name), mesh_names_), static_cast<int>(body_), begin,
                         static_cast<int>(all_.polygons.count())});
}

template <class OfCorner>
void TopologyBuilder::add_polygon(std::span<const int> points, Source& source, int like, const OfCorner& of_corner) {
  const Polygons& file = source.file.polygons;
  Polygons& all = all_.polygons;
  all.add(points);
  all.group.push_back(group_of(source, like)), all.material.push_back(material_of(source, like));
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int corner = like < 0 || file.corner_uv.empty() ? -1 : of_corner(k);
    const int in_file = corner < 0 ? -1 : file.corner_uv[static_cast<std::size_t>(file.begin[like] + corner)];
    if (in_file < 0) {
      all.corner_uv.push_back(-1);
      continue;
    }
    int& uv = source.new_uv[static_cast<std::size_t>(in_file)];
    if (uv < 0) {
      const auto [u, v] = file.uv[static_cast<std::size_t>(in_file)];
      uv = static_cast<int>(all.uv.size());
      all.uv.push_back({u, is_gltf_file(source.path) ? 1 - v : v});  // glTF counts v from above
    }
    all.corner_uv.push_back(uv);
  }
}

void TopologyBuilder::add_polygons_of_file(int begin, Source& source) {
  const Polygons& file = source.file.polygons;
  const std::vector<Run> runs = runs_of_objects(source.file);
  std::vector<int> points;
  for (const Run& run : runs) {
    const auto object = static_cast<std::size_t>(run.object);
    const bool is_named = object < file.objects.size() && !file.objects[object].empty();
    add_mesh(is_named ? file.objects[object] : scene_.bodies[body_].name, begin + run.begin);
    for (std::size_t f = 0; f < file.count(); ++f) {
      if (runs.size() > 1 && object_of(file, file.object, f) != run.object) continue;
      points.clear();
      for (const int v : file.corners_of(f)) points.push_back(begin + v);
      add_polygon(points, source, static_cast<int>(f), [](std::size_t k) { return static_cast<int>(k); });
    }
  }
}

/// The faces are in the order of the file's polygons, some of which are triangulated, reduced to a half, or left out. A
/// point that tearing added starts where the point that it was split from does.
void TopologyBuilder::add_faces(int begin, int end, const std::vector<Quad>& faces, Source& source) {
  const Polygons& file = source.file.polygons;
  std::vector<int> first;  // point at the same position, of each point of the body
  if (!source.path.empty()) first = first_at_same_position({all_.rest.begin() + begin, all_.rest.begin() + end});
  const auto corner_at = [&](std::size_t polygon, int point) {
    const std::span<const int> corners = file.corners_of(polygon);
    const auto at = std::ranges::find_if(corners, [&](int v) {
      return first[static_cast<std::size_t>(v)] == first[static_cast<std::size_t>(point - begin)];
    });
    return at == corners.end() ? -1 : static_cast<int>(at - corners.begin());
  };
  std::size_t polygon = 0;
  for (const Quad& face : faces) {
    const auto points = std::span<const int>(face).first(is_triangle(face) ? 3 : 4);
    while (polygon < file.count() &&
           !std::ranges::all_of(points, [&](int point) { return corner_at(polygon, point) >= 0; }))
      ++polygon;
    add_polygon(points, source, polygon < file.count() ? static_cast<int>(polygon) : -1,
                [&](std::size_t k) { return corner_at(polygon, points[k]); });
  }
}

int TopologyBuilder::group_of(const Source& source, int polygon) {
  const Polygons& file = source.file.polygons;
  const int group = polygon < 0 || file.group.empty() ? -1 : file.group[static_cast<std::size_t>(polygon)];
  if (group < 0) return -1;
  const std::string& name = file.groups[static_cast<std::size_t>(group)];
  const auto [known, is_new] = groups_.try_emplace(name, static_cast<int>(all_.polygons.groups.size()));
  if (is_new) all_.polygons.groups.push_back(name);
  return known->second;
}

int TopologyBuilder::material_of(const Source& source, int polygon) {
  const Polygons& file = source.file.polygons;
  const int index = polygon < 0 || file.material.empty() ? -1 : file.material[static_cast<std::size_t>(polygon)];
  if (index < 0) return -1;
  const auto [known, is_new] = materials_.try_emplace({source.path, index}, static_cast<int>(all_.materials.size()));
  if (is_new) {
    const std::string& name = file.materials[static_cast<std::size_t>(index)];
    all_.materials.push_back({unique_name(name.empty() ? "material" : printable(name), material_names_), source.path,
                              name, index, file.material_files});
  }
  return known->second;
}

}  // namespace malha
