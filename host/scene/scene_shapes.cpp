// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "host/scene/scene_fields.h"

namespace malha {

namespace {

constexpr int max_cells = 100000;     // along an axis
constexpr int max_subdivisions = 10;  // 10,485,762 points

void refuse_too_many(const JsonReader& at, double particles) {
  if (particles <= max_particles) return;
  std::string counts;
  if (at.value().is_array()) {
    for (const JsonValue& item : at.value().items()) counts += (counts.empty() ? "" : ", ") + describe(item);
    counts = "[" + counts + "]";
  }
  char number[40];
  std::snprintf(number, sizeof number, "%.0f", particles);
  at.refuse((counts.empty() ? describe(at.value()) : counts) + ", which makes " + number + " particles",
            "counts that make at most 20000000 particles");
}

namespace fs = std::filesystem;

/// The absolute path, which is valid in any folder, or the path relative to `folder`, if that is not empty. The name of
/// the file is kept even if it is a link, since its extension gives the format.
std::string path_from(const std::string& folder, const fs::path& path) {
  const fs::path whole = fs::absolute(path);
  if (folder.empty()) return whole.string();
  std::error_code gone;  // the folder may have been removed meanwhile
  const fs::path relative = fs::relative(whole.parent_path(), folder, gone);
  return gone || relative.empty() ? whole.string() : (relative / whole.filename()).lexically_normal().string();
}

/// A path of a scene in this folder.
std::string resolved(const std::string& folder, const std::string& path) {
  return (fs::path(folder) / path).lexically_normal().string();
}

}  // namespace

Field path_field(const std::string& key, std::string& path, const std::string& folder) {
  const auto read = [&path, folder](const JsonReader& at) {
    path = (fs::path(folder) / at.text()).lexically_normal().string();
  };
  return {key, read, false, [&path, key, folder](JsonValue& json) { json[key] = path_from(folder, path); }};
}

/// The fields of a grid and a tet_box.
template <class Cells>
requires requires(Cells of) { of.size, of.cells[0]; }
static Fields fields_of(Cells& of) {
  return {required(field("size", of.size, above(0, "m"))), required(field("cells", of.cells, Integers{1, max_cells}))};
}
static void check(const JsonReader& at, const GridShape& grid) {
  refuse_too_many(at.at("cells"), (grid.cells[0] + 1.0) * (grid.cells[1] + 1.0));
}

static Fields fields_of(SphereShape& sphere) {
  return {required(field("radius", sphere.radius, above(0, "m"))),
          field("subdivisions", sphere.subdivisions, Integers{0, max_subdivisions})};
}

static Fields fields_of(BoxShape& box) {
  return {required(field("size", box.size, above(0, "m"))), field("cells", box.cells, Integers{1, max_cells})};
}
static void check(const JsonReader& at, const BoxShape& box) {
  if (!box.cells) return;
  const auto [x, y, z] = *box.cells;
  refuse_too_many(at.at("cells"), 2 * (1.0 * x * y + 1.0 * y * z + 1.0 * z * x) + 2);
}

static void check(const JsonReader& at, const TetBoxShape& box) {
  refuse_too_many(at.at("cells"), (box.cells[0] + 1.0) * (box.cells[1] + 1.0) * (box.cells[2] + 1.0));
}

static Fields fields_of(BarShape& bar) {
  return {required(field("length", bar.length, above(0, "m"))), required(field("width", bar.width, above(0, "m"))),
          required(field("cells", bar.cells, Integers{1, max_cells}))};
}
static void check(const JsonReader& at, const BarShape& bar) {
  const double along = bar.length / bar.width * bar.cells;
  if (along > max_cells)
    at.at("cells").refuse_value("a number of cells for which at most " + std::to_string(max_cells) +
                                " fit along the length");
  refuse_too_many(at.at("cells"), 2.0 * bar.cells * (bar.cells + 2 * along));
}

static Fields fields_of(PlaneShape&) { return {}; }
/// The fields of a capsule and a cylinder.
template <class Line>
requires requires(Line of) { of.from, of.to, of.radius; }
static Fields fields_of(Line& of) {
  return {required(field("from", of.from, any("m"))), required(field("to", of.to, any("m"))),
          required(field("radius", of.radius, above(0, "m")))};
}
template <class Line>
requires requires(Line of) { of.from, of.to, of.radius; }
static void check(const JsonReader& at, const Line& of) {
  if (of.from == of.to) at.at("to").refuse("the same point as 'from'", "another point");
}

static Fields fields_of(ChainShape& chain) {
  constexpr int max_segments = 10000000;
  return {required(field("from", chain.from, any("m"))), required(field("to", chain.to, any("m"))),
          required(field("segments", chain.segments, Integers{1, max_segments}))};
}
static void check(const JsonReader& at, const ChainShape& chain) {
  if (chain.from == chain.to) at.at("to").refuse("the same point as 'from'", "another point");
}

static Fields fields_of(LatticeShape& lattice) {
  return {required(field("min", lattice.min, any("m"))), required(field("max", lattice.max, any("m"))),
          required(field("count", lattice.count, Integers{1, max_cells}))};
}
static void check(const JsonReader& at, const LatticeShape& lattice) {
  for (std::size_t i = 0; i < 3; ++i) {
    const bool fits = lattice.count[i] > 1 ? lattice.min[i] < lattice.max[i] : lattice.min[i] <= lattice.max[i];
    if (!fits) at.at("max").list()[i].refuse_value("a number above that of 'min' (m)");
  }
  refuse_too_many(at.at("count"), 1.0 * lattice.count[0] * lattice.count[1] * lattice.count[2]);
}

static Fields fields_of(MeshDataShape& data) {
  constexpr Integers indices{0, 2147483647};  // that the points exist is checked when the mesh is generated
  const auto read_faces = [&data, indices](const JsonReader& at) {
    for (const JsonReader& face : at.list()) {
      const std::size_t corners = face.list().size();
      if (corners != 3 && corners != 4)
        face.refuse("a list of " + std::to_string(corners), "a list of 3 or 4 vertices, from 0");
      std::vector<int> all;
      read_into(all, face, indices);
      data.faces.push_back({all[0], all[1], all[2], corners == 4 ? all[3] : -1});
    }
  };
  const auto write_faces = [&data](JsonValue& json) {
    for (const Quad& face : data.faces)
      json["faces"].push_back(is_triangle(face) ? JsonValue(Triangle{face[0], face[1], face[2]}) : JsonValue(face));
  };
  return {required(checked(field("points", data.points, any("m")),
                           [&data](const JsonReader& at) {
                             if (data.points.empty()) at.refuse("a list of 0", "a list of points (m)");
                             if (data.points.size() > max_particles)
                               at.refuse(std::to_string(data.points.size()) + " points", "at most 20000000");
                           })),
          {"faces", read_faces, false, write_faces},
          written_if(!data.lines.empty(), field("lines", data.lines, indices)),
          written_if(!data.tetrahedra.empty(), field("tetrahedra", data.tetrahedra, indices))};
}

namespace {

Field mesh_field(Shape& shape, const std::string& folder) {
  const auto read = [&shape, folder](const JsonReader& at) { shape = MeshFile{resolved(folder, at.text())}; };
  return {"mesh", read, false, [&shape, folder](JsonValue& json) {
            if (const auto* file = std::get_if<MeshFile>(&shape)) json["mesh"] = path_from(folder, file->path);
          }};
}

/// A shape that is exact unless `mesh` says how it is meshed.
template <class T, class Value>
Field meshed_or_exact(const std::string& key, Shape& shape, std::optional<Value> T::*mesh) {
  Field field = alternative<T>(key, shape);
  field.read = [&shape, mesh](const JsonReader& at) {
    T held;
    (held.*mesh).reset();
    at.object(fields_of(held)), check(at, held);
    shape = held;
  };
  return field;
}

Fields kinds_of_shapes(Shape& shape, ShapeUse use, const std::string& folder) {
  Fields kinds{mesh_field(shape, folder),
               alternative<GridShape>("grid", shape),
               meshed_or_exact("sphere", shape, &SphereShape::subdivisions),
               meshed_or_exact("box", shape, &BoxShape::cells),
               alternative<BarShape>("bar", shape),
               alternative<MeshDataShape>("mesh_data", shape)};
  const Fields of_bodies{alternative<ChainShape>("chain", shape), alternative<LatticeShape>("lattice", shape),
                         alternative<TetBoxShape>("tet_box", shape)};
  const Fields of_environment{alternative<PlaneShape>("plane", shape), alternative<CapsuleShape>("capsule", shape),
                              alternative<CylinderShape>("cylinder", shape)};
  if (use != ShapeUse::Environment) kinds.insert(kinds.end(), of_bodies.begin(), of_bodies.end());
  if (use != ShapeUse::Body) kinds.insert(kinds.end(), of_environment.begin(), of_environment.end());
  return kinds;
}

/// Refuses an exact shape of a body, whose particles are the points of a mesh.
void refuse_exact(const JsonReader& at, const Shape& shape) {
  if (std::holds_alternative<SphereShape>(shape))
    at.at("sphere").refuse("a sphere without 'subdivisions', which is exact and has no points",
                           "'subdivisions' beside 'radius'; exact spheres are for the environment");
  at.at("box").refuse("a box without 'cells', which is exact and has no points",
                      "'cells' beside 'size'; exact boxes are for the environment");
}

}  // namespace

Field shape_field(Shape& shape, ShapeUse use, const std::string& folder) {
  const auto read = [&shape, use, folder](const JsonReader& at) {
    std::optional<double> weld;
    Shape found;
    at.one_of(kinds_of_shapes(found, use, folder), {field("weld", weld, at_least(0, "m"))});
    if (weld && !std::holds_alternative<MeshFile>(found))
      at.at("weld").refuse("'weld' beside a generated shape", "'weld' beside 'mesh'");
    if (weld) std::get<MeshFile>(found).weld = weld;
    if (use == ShapeUse::Body && is_exact(found)) refuse_exact(at, found);
    shape = found;
  };
  return {"shape", read, false, [&shape, folder](JsonValue& json) {
            json["shape"] = write(kinds_of_shapes(shape, ShapeUse::Any, folder));
            if (const auto* file = std::get_if<MeshFile>(&shape)) write_to(json["shape"], "weld", file->weld);
          }};
}

Field rest_field(std::optional<RestSpec>& rest, const std::string& folder) {
  const auto fields = [folder](RestSpec& of) {
    const auto read_path = [&of, folder](const JsonReader& at) { of = RestMesh{resolved(folder, at.text())}; };
    const auto write_path = [&of, folder](JsonValue& json) {
      if (const auto* file = std::get_if<RestMesh>(&of)) json["mesh"] = path_from(folder, file->path);
    };
    return Fields{{"mesh", read_path, false, write_path},
                  alternative("uv", of, &RestUv::metres, above(0, "m")),
                  alternative("points", of, &RestPoints::points, any("m"))};
  };
  const auto read = [&rest, fields](const JsonReader& at) {
    RestSpec found;
    at.one_of(fields(found));
    rest = std::move(found);
  };
  return {"rest", read, false, [&rest, fields](JsonValue& json) {
            if (rest) json["rest"] = write(fields(*rest));
          }};
}

Field rotation_field(Vec3& axis, double& degrees) {
  const auto fields = [&] {
    return Fields{required(field("axis", axis, any(""))), required(field("degrees", degrees, any("degrees")))};
  };
  const auto read = [&axis, fields](const JsonReader& at) {
    at.object(fields());
    const auto too_small = [](double x) { return -1 / largest_number < x && x < 1 / largest_number; };
    if (std::all_of(axis.begin(), axis.end(), too_small)) at.at("axis").refuse("a zero axis", "a direction");
  };
  return {"rotate", read, false, [fields](JsonValue& json) { json["rotate"] = write(fields()); }};
}

Fields fields_of(Transform& transform) {
  const auto read_scale = [&transform](const JsonReader& at) {
    if (at.value().is_array()) return read_into(transform.scale, at, above(0, ""));
    transform.scale.fill(at.number(above(0, "a ratio, one for all directions or a list of 3")));
  };
  return {field("translate", transform.translate, any("m")),
          rotation_field(transform.axis, transform.degrees),
          {"scale", read_scale, false, [&](JsonValue& json) { json["scale"] = transform.scale; }}};
}

Fields box_fields(Vec3& min, Vec3& max) {
  return {required(field("min", min, any("m"))), required(field("max", max, any("m")))};
}

void check_box(const JsonReader& at, const Vec3& min, const Vec3& max) {
  for (std::size_t i = 0; i < 3; ++i)
    if (min[i] > max[i]) at.at("max").list()[i].refuse_value("a number not below that of 'min' (m)");
}

}  // namespace malha
