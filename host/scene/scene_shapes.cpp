// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "host/scene/scene_read.h"

namespace malha {
namespace {

constexpr int max_cells = 100000;     // along an axis
constexpr int max_subdivisions = 10;  // 10,485,762 points

void refuse_too_many(const JsonReader& at, double particles) {
  if (particles <= max_particles) return;
  std::string counts;
  const JsonValue& value = at.value();
  for (const JsonValue& item : value.items) counts += (counts.empty() ? "" : ", ") + describe(item);
  if (value.type == JsonValue::Type::List) counts = "[" + counts + "]";
  char number[40];
  std::snprintf(number, sizeof number, "%.0f", particles);
  at.refuse((counts.empty() ? describe(value) : counts) + ", which makes " + number + " particles",
            "counts that make at most 20000000 particles");
}

Shape read_mesh(const JsonReader& at, const std::string& folder) {
  return MeshFile{(std::filesystem::path(folder) / at.text()).lexically_normal().string()};
}

Shape read_grid(const JsonReader& at) {
  GridShape grid;
  at.object({
      {"size", [&](const JsonReader& v) { grid.size = v.numbers<2>(above(0, "m")); }, true},
      {"cells", [&](const JsonReader& v) { grid.cells = v.integers<2>(1, max_cells); }, true},
  });
  refuse_too_many(at.at("cells"), (grid.cells[0] + 1.0) * (grid.cells[1] + 1.0));
  return grid;
}

Shape read_sphere(const JsonReader& at) {
  SphereShape sphere;
  at.object({
      {"radius", [&](const JsonReader& v) { sphere.radius = v.number(above(0, "m")); }, true},
      {"subdivisions", [&](const JsonReader& v) { sphere.subdivisions = v.integer(0, max_subdivisions); }, true},
  });
  return sphere;
}

Shape read_box_shape(const JsonReader& at) {
  BoxShape box;
  at.object({
      {"size", [&](const JsonReader& v) { box.size = v.vec3(above(0, "m")); }, true},
      {"cells", [&](const JsonReader& v) { box.cells = v.integers<3>(1, max_cells); }, true},
  });
  const auto [x, y, z] = box.cells;
  refuse_too_many(at.at("cells"), 2 * (1.0 * x * y + 1.0 * y * z + 1.0 * z * x) + 2);
  return box;
}

Shape read_tet_box(const JsonReader& at) {
  TetBoxShape box;
  at.object({
      {"size", [&](const JsonReader& v) { box.size = v.vec3(above(0, "m")); }, true},
      {"cells", [&](const JsonReader& v) { box.cells = v.integers<3>(1, max_cells); }, true},
  });
  refuse_too_many(at.at("cells"), (box.cells[0] + 1.0) * (box.cells[1] + 1.0) * (box.cells[2] + 1.0));
  return box;
}

Shape read_bar(const JsonReader& at) {
  BarShape bar;
  at.object({
      {"length", [&](const JsonReader& v) { bar.length = v.number(above(0, "m")); }, true},
      {"width", [&](const JsonReader& v) { bar.width = v.number(above(0, "m")); }, true},
      {"cells", [&](const JsonReader& v) { bar.cells = v.integer(1, max_cells); }, true},
  });
  const double along = bar.length / bar.width * bar.cells;
  if (along > max_cells) {
    at.at("cells").refuse_value("a number of cells for which at most " + std::to_string(max_cells) +
                                " fit along the length");
  }
  refuse_too_many(at.at("cells"), 2.0 * bar.cells * (bar.cells + 2 * along));
  return bar;
}

Shape read_chain(const JsonReader& at) {
  constexpr int max_segments = 10000000;
  ChainShape chain;
  at.object({
      {"from", [&](const JsonReader& v) { chain.from = v.vec3(any("m")); }, true},
      {"to", [&](const JsonReader& v) { chain.to = v.vec3(any("m")); }, true},
      {"segments", [&](const JsonReader& v) { chain.segments = v.integer(1, max_segments); }, true},
  });
  if (chain.from == chain.to) at.at("to").refuse("the same point as 'from'", "another point");
  return chain;
}

Shape read_lattice(const JsonReader& at) {
  LatticeShape lattice;
  at.object({
      {"min", [&](const JsonReader& v) { lattice.min = v.vec3(any("m")); }, true},
      {"max", [&](const JsonReader& v) { lattice.max = v.vec3(any("m")); }, true},
      {"count", [&](const JsonReader& v) { lattice.count = v.integers<3>(1, max_cells); }, true},
  });
  for (std::size_t i = 0; i < 3; ++i) {
    const bool fits = lattice.count[i] > 1 ? lattice.min[i] < lattice.max[i] : lattice.min[i] <= lattice.max[i];
    if (!fits) at.at("max").list()[i].refuse_value("a number above that of 'min' (m)");
  }
  refuse_too_many(at.at("count"), 1.0 * lattice.count[0] * lattice.count[1] * lattice.count[2]);
  return lattice;
}

Shape read_mesh_data(const JsonReader& at) {
  constexpr int max_index = 2147483647;  // that the points exist is checked when the mesh is generated
  MeshDataShape data;
  const auto add_face = [&](const JsonReader& v) {
    if (v.list().size() == 4) {
      data.faces.push_back(v.integers<4>(0, max_index));
    } else if (v.list().size() == 3) {
      const auto [a, b, c] = v.integers<3>(0, max_index);
      data.faces.push_back({a, b, c, -1});
    } else {
      v.refuse("a list of " + std::to_string(v.list().size()), "a list of 3 or 4 vertices, from 0");
    }
  };
  at.object({
      {"points",
       [&](const JsonReader& v) {
         for (const JsonReader& point : v.list()) data.points.push_back(point.vec3(any("m")));
         if (data.points.empty()) v.refuse("a list of 0", "a list of points (m)");
         if (data.points.size() > max_particles)
           v.refuse(std::to_string(data.points.size()) + " points", "at most 20000000");
       },
       true},
      {"faces",
       [&](const JsonReader& v) {
         for (const JsonReader& face : v.list()) add_face(face);
       }},
      {"lines",
       [&](const JsonReader& v) {
         for (const JsonReader& line : v.list()) data.lines.push_back(line.integers<2>(0, max_index));
       }},
      {"tetrahedra",
       [&](const JsonReader& v) {
         for (const JsonReader& one : v.list()) data.tetrahedra.push_back(one.integers<4>(0, max_index));
       }},
  });
  return data;
}

Vec3 read_scale(const JsonReader& at) {
  if (at.value().type == JsonValue::Type::List) return at.vec3(above(0, ""));
  const double scale = at.number(above(0, "a ratio, one for all directions or a list of 3"));
  return {scale, scale, scale};
}

}  // namespace

Shape read_shape(const JsonReader& at, ShapeUse use, const std::string& folder) {
  Shape shape;
  std::vector<JsonReader::Field> fields{
      {"mesh", [&](const JsonReader& v) { shape = read_mesh(v, folder); }},
      {"grid", [&](const JsonReader& v) { shape = read_grid(v); }},
      {"sphere", [&](const JsonReader& v) { shape = read_sphere(v); }},
      {"box", [&](const JsonReader& v) { shape = read_box_shape(v); }},
      {"bar", [&](const JsonReader& v) { shape = read_bar(v); }},
      {"mesh_data", [&](const JsonReader& v) { shape = read_mesh_data(v); }},
  };
  if (use == ShapeUse::Body) {
    fields.push_back({"chain", [&](const JsonReader& v) { shape = read_chain(v); }});
    fields.push_back({"lattice", [&](const JsonReader& v) { shape = read_lattice(v); }});
    fields.push_back({"tet_box", [&](const JsonReader& v) { shape = read_tet_box(v); }});
  }
  std::optional<double> weld;
  at.one_of(fields, {{"weld", [&](const JsonReader& v) { weld = v.number(at_least(0, "m")); }}});
  if (!weld) return shape;
  auto* file = std::get_if<MeshFile>(&shape);
  if (file == nullptr) at.at("weld").refuse("'weld' beside a generated shape", "'weld' beside 'mesh'");
  file->weld = weld;
  return shape;
}

void read_rotation(const JsonReader& at, Vec3& axis, double& degrees) {
  at.object({
      {"axis", [&](const JsonReader& v) { axis = v.vec3(any("")); }, true},
      {"degrees", [&](const JsonReader& v) { degrees = v.number(any("degrees")); }, true},
  });
  const auto too_small = [](double x) { return -1 / largest_number < x && x < 1 / largest_number; };
  if (std::all_of(axis.begin(), axis.end(), too_small)) at.at("axis").refuse("a zero axis", "a direction");
}

Transform read_transform(const JsonReader& at) {
  Transform transform;
  at.object({
      {"translate", [&](const JsonReader& v) { transform.translate = v.vec3(any("m")); }},
      {"rotate", [&](const JsonReader& v) { read_rotation(v, transform.axis, transform.degrees); }},
      {"scale", [&](const JsonReader& v) { transform.scale = read_scale(v); }},
  });
  return transform;
}

void read_box(const JsonReader& at, Vec3& min, Vec3& max) {
  at.object({
      {"min", [&](const JsonReader& v) { min = v.vec3(any("m")); }, true},
      {"max", [&](const JsonReader& v) { max = v.vec3(any("m")); }, true},
  });
  for (std::size_t i = 0; i < 3; ++i) {
    if (min[i] > max[i]) at.at("max").list()[i].refuse_value("a number not below that of 'min' (m)");
  }
}

}  // namespace malha
