// SPDX-License-Identifier: Apache-2.0
#include "tools/python/scene.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "malha/error.h"
#include "malha/text.h"
#include "tools/python/arguments.h"
#include "tools/python/arrays.h"

namespace malha::python {

namespace py = pybind11;
using namespace py::literals;

namespace {

/// Converts values that the json module does not support: arrays and numbers of numpy.
py::object plain(const py::object& value) {
  if (py::hasattr(value, "tolist") && py::hasattr(value, "dtype"))
    if (const auto kind = value.attr("dtype").attr("kind").cast<std::string>(); kind != "M" && kind != "m")
      return value.attr("tolist")();
  refuse("scene", "", "a value of type " + type_of(value),
         "dicts, lists, arrays, texts, numbers, True, False and None");
}

/// Refuses the first number that is not finite, which JSON cannot represent. `at`: path of the value, as
/// "/bodies/0/mass".
void refuse_not_finite(const py::handle& value, const std::string& at) {
  if (py::isinstance<py::dict>(value)) {
    for (const auto& [key, one] : py::reinterpret_borrow<py::dict>(value))
      refuse_not_finite(one, at + "/" + text_of(py::str(key)));
  } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    for (std::size_t i = 0; i < py::len(value); ++i)
      refuse_not_finite(value[py::int_(i)], at + "/" + std::to_string(i));
  } else if (py::hasattr(value, "tolist")) {
    refuse_not_finite(value.attr("tolist")(), at);
  } else if (PyFloat_Check(value.ptr()) && !std::isfinite(PyFloat_AsDouble(value.ptr()))) {
    refuse("scene", at, py::str(value).cast<std::string>(), "finite numbers");
  }
}

/// Writes a dict as JSON.
std::string json_text(const py::dict& scene) {
  try {
    return py::module_::import("json")
        .attr("dumps")(scene, "default"_a = py::cpp_function(plain), "allow_nan"_a = false)
        .cast<std::string>();
  } catch (const py::error_already_set& error) {
    // A dict that contains itself would recurse forever.
    const bool endless = std::string(error.what()).find("Circular") != std::string::npos;
    if (error.matches(PyExc_ValueError) && !endless) refuse_not_finite(scene, "");
    throw;
  }
}

std::string path_of(const py::object& path) {
  return py::module_::import("os").attr("fsencode")(path).cast<std::string>();
}

/// Returns a row of corners without the -1 that ends a triangle.
py::object without_end(const py::object& row) {
  const bool triangle =
      py::isinstance<py::sequence>(row) && py::len(row) == 4 && py::object(row[py::int_(3)]).equal(py::int_(-1));
  return triangle ? py::object(row[py::slice(0, 3, 1)]) : row;
}

/// Adds a key of mesh_data; lists of lists if faces have 3 and 4 corners.
void add_corners(py::dict& mesh_data, const char* key, const py::object& given, int least, int most) {
  if (given.is_none()) return;
  const bool mixed = most > least && py::isinstance<py::list>(given);
  const py::array array = mixed ? py::array() : numbers_of(given, false);
  if (mixed) {
    py::list rows;
    for (const py::handle row : given) rows.append(without_end(py::reinterpret_borrow<py::object>(row)));
    mesh_data[key] = rows;
    return;
  }
  if (!array) PyErr_Clear();
  const bool whole = array && (array.dtype().kind() == 'i' || array.dtype().kind() == 'u' || array.size() == 0);
  if (!whole || array.ndim() != 2 || array.shape(1) < least || array.shape(1) > most)
    refuse(
        "body", key, found_in(array) + (array && !whole ? " that are no whole numbers" : ""),
        "whole numbers (N, " + std::to_string(least) + (most > least ? ") or (N, " + std::to_string(most) : "") + ")");
  if (array.size() > 0) mesh_data[key] = array;
}

py::dict shape(const py::object& points, const py::object& faces, const py::object& lines,
               const py::object& tetrahedra) {
  const std::vector<Vec3> rows = rows_of(points, "body: points");
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const double number : rows[i])
      if (!(std::abs(number) <= 1e18))
        refuse("body", "points: row " + std::to_string(i), shown(number), "numbers up to 1e18");
  py::dict mesh_data("points"_a = array_of(rows));
  add_corners(mesh_data, "faces", faces, 3, 4), add_corners(mesh_data, "lines", lines, 2, 2);
  add_corners(mesh_data, "tetrahedra", tetrahedra, 4, 4);
  return py::dict("mesh_data"_a = mesh_data);
}

/// Reads rows of corners from an array; shorter rows end with -1.
template <class Item>
std::vector<Item> items_of(const py::dict& mesh_data, const char* key) {
  std::vector<Item> items;
  if (!mesh_data.contains(key)) return items;
  const auto array = py::array(py::object(mesh_data[key]));
  const std::vector<int> numbers = integers_of(array, key);
  const std::size_t corners = numbers.empty() ? 1 : static_cast<std::size_t>(array.shape(1));
  for (std::size_t i = 0; i < numbers.size(); i += corners) {
    Item item;
    item.fill(-1);
    std::copy_n(&numbers[i], std::min(corners, item.size()), item.begin());
    items.push_back(item);
  }
  return items;
}

/// Reads mesh_data whose values are all arrays, as shape() makes them; returns none for others, which are converted by
/// JSON.
std::optional<MeshDataShape> arrays_of(const py::handle& shape) {
  if (!py::isinstance<py::dict>(shape) || py::len(shape) != 1) return std::nullopt;
  const auto dict = shape.cast<py::dict>();
  if (!dict.contains("mesh_data") || !py::isinstance<py::dict>(dict["mesh_data"])) return std::nullopt;
  const py::dict mesh_data = dict["mesh_data"];
  for (const auto& [key, value] : mesh_data) {
    const std::string name = py::str(key);
    const std::size_t most = name == "points" ? 3 : name == "lines" ? 2 : 4, least = name == "faces" ? 3 : most;
    if (name != "points" && name != "faces" && name != "lines" && name != "tetrahedra") return std::nullopt;
    if (!py::isinstance<py::array>(value)) return std::nullopt;
    const auto array = value.cast<py::array>();
    if (array.ndim() != 2 || array.shape(0) == 0 || static_cast<std::size_t>(array.shape(1)) < least ||
        static_cast<std::size_t>(array.shape(1)) > most)
      return std::nullopt;
  }
  if (!mesh_data.contains("points")) return std::nullopt;
  return MeshDataShape{rows_of(mesh_data["points"], "body: points"), items_of<Quad>(mesh_data, "faces"),
                       items_of<Edge>(mesh_data, "lines"), items_of<Tetrahedron>(mesh_data, "tetrahedra")};
}

/// Arrays that replace a small placeholder shape after JSON was parsed, because JSON would take ten times as long.
struct PendingShape {
  bool environment;
  std::size_t index;
  MeshDataShape shape;
};

/// The places of a body at rest, which replace none.
struct PendingRest {
  std::size_t body;
  std::vector<Vec3> points;
};

/// Takes an array of points out of the "rest" of a body's dict.
void take_rest(py::dict& body, std::size_t index, std::vector<PendingRest>& waiting) {
  if (!body.contains("rest") || !py::isinstance<py::dict>(body["rest"])) return;
  const auto rest = body["rest"].cast<py::dict>();
  if (py::len(rest) != 1 || !rest.contains("points") || !py::isinstance<py::array>(rest["points"])) return;
  waiting.push_back({index, rows_of(rest["points"], "body: rest: points")});
  body["rest"] = py::dict("points"_a = py::list());
}

/// Returns a copy of the scene's dict with such placeholders.
py::dict without_arrays(const py::dict& scene, std::vector<PendingShape>& waiting, std::vector<PendingRest>& rests) {
  py::dict copy = scene.attr("copy")();
  for (const char* const key : {"bodies", "environment"}) {
    if (!copy.contains(key) || !py::isinstance<py::list>(copy[key])) continue;
    py::list all = py::object(copy[key]).attr("copy")();
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!py::isinstance<py::dict>(all[i]) || !py::object(all[i]).contains("shape")) continue;
      py::dict one = py::object(all[i]).attr("copy")();
      if (std::string(key) == "bodies") take_rest(one, i, rests), all[i] = one;
      std::optional<MeshDataShape> shape = arrays_of(py::object(one["shape"]));
      if (!shape) continue;
      py::dict small("points"_a = py::make_tuple(py::make_tuple(0, 0, 0)));
      if (!shape->loose()) small["lines"] = py::make_tuple(py::make_tuple(0, 0));
      one["shape"] = py::dict("mesh_data"_a = small);
      all[i] = one;
      waiting.push_back({std::string(key) == "environment", i, std::move(*shape)});
    }
    copy[key] = all;
  }
  return copy;
}

py::dict body(const py::object& points, const py::object& faces, const py::object& lines, const py::object& tetrahedra,
              const std::string& name, const py::object& pins, const py::kwargs& more) {
  py::dict made("name"_a = name, "shape"_a = shape(points, faces, lines, tetrahedra));
  if (!pins.is_none()) {
    const bool dicts =
        py::isinstance<py::list>(pins) && py::len(pins) > 0 && py::isinstance<py::dict>(pins.cast<py::list>()[0]);
    if (dicts) {
      made["pins"] = pins;
    } else if (const std::vector<int> numbers = integers_of(pins, "body: pins"); !numbers.empty()) {
      py::list list;
      for (const int number : numbers) list.append(number);
      py::list all;
      all.append(py::dict("particles"_a = list));
      made["pins"] = all;
    }
  }
  for (const auto& [key, value] : more) made[key] = value;
  return made;
}

}  // namespace

py::object parsed(const std::string& json) { return py::module_::import("json").attr("loads")(json); }

Scene scene_of(const py::object& source, const py::object& folder) {
  if (py::isinstance<Scene>(source)) return source.cast<Scene>();
  const std::string from = folder.is_none() ? "" : path_of(folder);
  if (py::isinstance<py::dict>(source)) {
    std::vector<PendingShape> waiting;
    std::vector<PendingRest> rests;
    Scene scene = parse_scene(json_text(without_arrays(source.cast<py::dict>(), waiting, rests)), "scene", from);
    for (PendingRest& one : rests) scene.bodies[one.body].rest = RestPoints{std::move(one.points)};
    for (PendingShape& one : waiting)
      (one.environment ? scene.environment[one.index].shape : scene.bodies[one.index].shape) = std::move(one.shape);
    return scene;
  }
  if (py::isinstance<py::str>(source) && source.attr("lstrip")(" \t\r\n")
                                             .attr("startswith")("{")
                                             .cast<bool>())  // a path may have bytes that are not UTF-8
    return parse_scene(text_of(source), "scene", from);
  if (!folder.is_none()) refuse("scene", "folder", "a folder beside a file", "one beside a dict or a JSON text");
  return load_scene(path_of(source));
}

void add_scene(py::module_& module) {
  py::class_<Scene>(module, "Scene",
                    "A scene: what is simulated, with what, in SI units. scenes/README.md explains every key.")
      .def(py::init(&scene_of), "source"_a, "folder"_a = py::none(),
           "A scene from a path, a JSON text (its first character is '{') or a dict, in which numpy arrays may stand "
           "for\n"
           "lists. folder: where relative mesh paths of a text or dict start; the working directory by default.\n"
           "Raises InputError with the place, what was found and what is allowed.")
      .def(
          "to_dict", [](const Scene& scene) { return parsed(to_json(scene)); },
          "The scene as a dict, every value spelled out: change it, and make another Scene of it.")
      .def(
          "to_json", [](const Scene& scene) { return to_json(scene); },
          "The same as JSON text, which `malha run` takes.")
      .def_property_readonly(
          "name", [](const Scene& scene) { return scene.name; }, "For people.")
      .def_property_readonly(
          "duration", [](const Scene& scene) { return scene.duration; }, "Of a whole run, s.")
      .def_property_readonly(
          "dt", [](const Scene& scene) { return scene.solver.dt; }, "A step, s.")
      .def(py::pickle(  // the working directory, because another process has another one
          [](const Scene& scene) { return py::make_tuple(to_json(scene), py::module_::import("os").attr("getcwd")()); },
          [](const py::tuple& state) {
            return parse_scene(state[0].cast<std::string>(), "scene", path_of(py::object(state[1])));
          }))
      .def("__repr__", [](const Scene& scene) {
        return "<malha.Scene '" + scene.name + "', " + counted(scene.bodies.size(), "body", "bodies") + ">";
      });
  module.def(
      "shape", &shape, "points"_a, "faces"_a = py::none(), "lines"_a = py::none(), "tetrahedra"_a = py::none(),
      "The \"shape\" of a body or an environment object from arrays: points (V, 3) in m; faces (F, 3) or (F, 4),\n"
      "where -1 ends a triangle, or a list of lists of both; lines (L, 2); tetrahedra (T, 4). Vertices count\n"
      "from 0; those that nothing uses are left out, and keep their number in pins and messages. With points\n"
      "alone the particles are loose.");
  module.def(
      "body", &body, "points"_a, "faces"_a = py::none(), "lines"_a = py::none(), "tetrahedra"_a = py::none(),
      py::kw_only(), "name"_a = "body", "pins"_a = py::none(),
      "A dict for a scene's \"bodies\" from arrays, see shape(). pins: numbers of vertices that do not move, or a\n"
      "list of dicts as in scenes. All other keys are those of a body in scenes, of which mass (kg), density or\n"
      "material is required: mass=0.2, constraints=[{\"type\": \"distance\"}], velocity=[0, 1, 0] ...");
}

}  // namespace malha::python
