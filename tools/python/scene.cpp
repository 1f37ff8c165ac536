#include "tools/python/scene.h"

#include <filesystem>

#include "host/base/shown.h"
#include "host/error.h"
#include "tools/python/arrays.h"

namespace malha::python {

namespace py = pybind11;
using namespace py::literals;

namespace {

/// What the json module does not know: arrays and numbers of numpy, and scenes.
py::object plain(const py::object& value) {
  if (py::hasattr(value, "tolist")) return value.attr("tolist")();
  refuse("scene", "", "a value of type " + py::str(py::type::of(value).attr("__name__")).cast<std::string>(),
         "dicts, lists, arrays, texts, numbers, True, False and None");
}

std::string path_of(const py::object& path) {
  return py::module_::import("os").attr("fspath")(path).cast<std::string>();
}

void add_rows(py::dict& shape, const char* key, const py::object& given, int least, int most) {
  if (given.is_none()) return;
  const py::array array = py::array::ensure(given);
  if (!array) {
    PyErr_Clear();
    shape[key] = given;  // lists of faces of 3 and 4 are no array
    return;
  }
  const std::string allowed =
      "whole numbers (N, " + std::to_string(least) + (most > least ? ") or (N, " + std::to_string(most) : "") + ")";
  if (array.dtype().kind() == 'O') {
    shape[key] = given;
    return;
  }
  const bool whole = array.dtype().kind() == 'i' || array.dtype().kind() == 'u';
  if (array.ndim() != 2 || array.shape(1) < least || array.shape(1) > most || (!whole && array.size() > 0))
    refuse("body", key, "an array of shape " + shape_of(array) + (whole ? "" : " that are no whole numbers"), allowed);
  py::list rows = array.attr("tolist")();
  if (most == 4 && least == 3 && array.shape(1) == 4)
    for (py::handle row : rows) {
      auto corners = row.cast<py::list>();
      if (corners[3].cast<long long>() == -1) corners.attr("pop")();
    }
  shape[key] = rows;
}

py::dict shape(const py::object& points, const py::object& faces, const py::object& lines,
               const py::object& tetrahedra) {
  const std::vector<Vec3> rows = rows_of(points, "body: points");
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const double number : rows[i])
      if (!(std::abs(number) <= 1e18))
        refuse("body", "points: row " + std::to_string(i), shown(number), "numbers up to 1e18");
  py::dict listed;
  listed["points"] = Doubles::ensure(points).attr("tolist")();
  add_rows(listed, "faces", faces, 3, 4), add_rows(listed, "lines", lines, 2, 2);
  add_rows(listed, "tetrahedra", tetrahedra, 4, 4);
  return py::dict("listed"_a = listed);
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
    const py::object text = py::module_::import("json").attr("dumps")(source, "default"_a = py::cpp_function(plain));
    return parse_scene(text.cast<std::string>(), "scene", from);
  }
  if (py::isinstance<py::str>(source)) {
    const auto text = source.cast<std::string>();
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first != std::string::npos && text[first] == '{') return parse_scene(text, "scene", from);
  }
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
      .def("to_json", &to_json, "The same as JSON text, which `malha run` takes.")
      .def_property_readonly("name", [](const Scene& scene) { return scene.name; })
      .def_property_readonly(
          "duration", [](const Scene& scene) { return scene.duration; }, "Of a whole run, s.")
      .def_property_readonly(
          "dt", [](const Scene& scene) { return scene.solver.dt; }, "A step, s.")
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
      "list of dicts as in scenes. All other keys are those of a body in scenes, of which mass (kg) or density\n"
      "is required: mass=0.2, constraints=[{\"type\": \"distance\"}], velocity=[0, 1, 0] ...");
}

}  // namespace malha::python
