// SPDX-License-Identifier: Apache-2.0
#include "tools/python/simulation.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>

#include "host/attachments/pose.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/report/plan.h"
#include "host/report/report.h"
#include "host/report/warnings.h"
#include "tools/python/arrays.h"
#include "tools/python/constraint.h"
#include "tools/python/running.h"
#include "tools/python/scene.h"

namespace malha::python {

namespace py = pybind11;
using namespace py::literals;

/// A body of a simulation, with its ranges of particles and faces.
struct BodyOf {
  std::string name;
  int first = 0, end = 0, first_face = 0, end_face = 0;
  std::vector<int> vertices;
};

}  // namespace malha::python

namespace pybind11::detail {
template <>
class type_caster<malha::python::BodyOf> : public malha::python::InitialisedCaster<malha::python::BodyOf> {};
}  // namespace pybind11::detail

namespace malha::python {

namespace {

py::slice slice(int first, int end) { return {first, end, 1}; }

std::vector<BodyOf> bodies_of(PySimulation& py_simulation) {
  const auto use = py_simulation.now();
  const Simulation& simulation = *use;
  const RenderMesh& render_mesh = simulation.model().render_mesh;
  std::vector<BodyOf> all;
  for (std::size_t b = 0; b + 1 < render_mesh.body_begin.size(); ++b)
    all.push_back({simulation.model().scene.bodies[b].name, render_mesh.body_begin[b], render_mesh.body_begin[b + 1],
                   render_mesh.face_begin[b], render_mesh.face_begin[b + 1], simulation.particles_of_vertices(b)});
  return all;
}

std::vector<Edge> edges_of(const py::object& given) {
  const py::array array = py::array::ensure(given);
  if (!array) PyErr_Clear();
  if (!array || array.ndim() != 2 || array.shape(1) != 2) refuse("cut", "edges", found_in(array), "an array (E, 2)");
  const std::vector<int> numbers = integers_of(array, "cut: edges");
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < numbers.size(); i += 2) edges.push_back({numbers[i], numbers[i + 1]});
  return edges;
}

/// The pose that a rotation and a translation, or a matrix of both, say.
RigidPose pose_of(const py::object& translate, const py::object& axis, double degrees, const py::object& matrix) {
  RigidPose pose;
  pose.degrees = degrees;
  if (!translate.is_none()) pose.translate = vector_of(translate, "set_pose: translate");
  if (!axis.is_none()) pose.axis = vector_of(axis, "set_pose: axis");
  if (matrix.is_none()) return pose;
  if (!translate.is_none() || !axis.is_none() || degrees != 0)
    refuse("set_pose", "", "a matrix beside a translation or a rotation", "one of both");
  const Doubles array = doubles_of(matrix);
  if (!array || array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4)
    refuse("set_pose", "matrix", found_in(array), "an array (4, 4)");
  const double* const m = array.data();
  Pose read;
  read.moves = true, read.t = {m[3], m[7], m[11]};
  double off = std::abs(m[12]) + std::abs(m[13]) + std::abs(m[14]) + std::abs(m[15] - 1);  // from a rigid motion
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      read.r[3 * i + k] = m[4 * i + k];
      double product = i == k ? -1 : 0;
      for (int j = 0; j < 3; ++j) product += m[4 * i + j] * m[4 * k + j];
      off += std::abs(product);
    }
  const double handed =
      m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
  if (!(off < 1e-5 && handed > 0))
    refuse("set_pose", "matrix", "a scale, a shear, a mirror, or a last row other than 0 0 0 1",
           "a rotation and a translation");
  return rigid_pose_of(read);
}

/// Calls copy(simulation, numbers, stride) for an array (N, 3) of either precision, which it fills.
template <class Copy>
void copy_into(PySimulation& py_simulation, const py::array& out, const char* call, const Copy& copy) {
  const auto use = py_simulation.now();
  const auto particles = static_cast<py::ssize_t>(use->model().x.size());
  const bool in_float = out.dtype().equal(py::dtype::of<float>()),
             in_double = out.dtype().equal(py::dtype::of<double>());
  const py::ssize_t size = out.itemsize();
  // Rows of three neighbouring numbers, which may be parts of longer ones.
  const auto has_rows = [&] {
    return out.strides(1) == size && out.strides(0) >= 3 * size && out.strides(0) % size == 0;
  };
  if (!(in_float || in_double) || !out.writeable() || out.ndim() != 2 || out.shape(0) != particles ||
      out.shape(1) != 3 || !(has_rows() || particles == 0))
    refuse(call, "out", found_in(out) + " of " + py::str(out.dtype()).cast<std::string>(),
           "a writeable array (" + std::to_string(particles) +
               ", 3) of float32 or float64 in C order, or columns of such an array");
  py::array filled = out;
  const auto stride = static_cast<std::size_t>(out.strides(0) / size);
  if (in_float)
    copy(*use, static_cast<float*>(filled.mutable_data()), stride);
  else
    copy(*use, static_cast<double*>(filled.mutable_data()), stride);
}

py::list handle_dicts(PySimulation& py_simulation) {
  py::list all;
  for (const ParticleHandle& one : py_simulation.now()->handles()) {
    py::dict taken("particle"_a = one.particle, "to"_a = py::make_tuple(one.to[0], one.to[1], one.to[2]));
    if (!one.is_held()) taken["compliance"] = one.compliance;
    all.append(taken);
  }
  return all;
}

int visit(PySimulation& py_simulation, visitproc visitor, void* argument) {
  return visitor(py_simulation.constraints.ptr(), argument);
}
void clear(PySimulation& py_simulation) { py_simulation.constraints = py::list(); }

using Class = py::class_<PySimulation>;

void add_state(Class& simulation) {
  simulation
      .def_property_readonly(
          "time", [](PySimulation& s) { return s.now()->time(); }, "Simulated time since the start, s.")
      .def_property_readonly(
          "steps", [](PySimulation& s) { return s.now()->steps(); }, "Number of steps since the start of the scene.")
      .def_property_readonly(
          "threads", [](PySimulation& s) { return s.now()->threads(); }, "Largest number of threads.")
      .def_property(
          "positions", [](PySimulation& s) { return array_of(s.now()->positions()); },
          [](PySimulation& s, const py::object& x) { s.set_positions(rows_of(x, "positions")); },
          "float64 (N, 3), m: a read-only copy, with all bodies concatenated in the order of the scene.\n"
          "Assign an array (N, 3) to move the particles: pins stay where they are put, and the state of contacts and\n"
          "sleep is reset.")
      .def_property(
          "velocities", [](PySimulation& s) { return array_of(s.now()->velocities()); },
          [](PySimulation& s, const py::object& given) {
            const std::vector<Vec3> v = rows_of(given, "velocities");
            s.compute([&](Simulation& of) { of.set_velocities(v); });
          },
          "float64 (N, 3), m/s: a read-only copy, assigned likewise. Pins keep velocity 0, or that of their keyframes.")
      .def_property(
          "pins", [](PySimulation& s) { return array_of(s.now()->pins()); },
          [](PySimulation& s, const py::object& given) {
            const std::vector<int> pins = integers_of(given, "pins", 1);
            s.compute([&](Simulation& of) { of.set_pins(pins); });
          },
          "int32 (P,): the particles that are pinned for good and rest, ascending. Assign others to release those "
          "that\n"
          "are left out, with their mass, and to hold the new ones where they are. All is laid out anew, which takes "
          "as\n"
          "long as the set-up. Pins on keyframes or with a release are not named, and stay. Refused: a scene that has\n"
          "torn, a body that has long_range and no pin, and particles that rigid attachments "
          "or pins on\n"
          "keyframes or with a release hold or have held.")
      .def(
          "copy_positions",
          [](PySimulation& s, const py::array& out) {
            copy_into(s, out, "copy_positions",
                      [](const Simulation& of, auto* to, std::size_t stride) { of.copy_positions(to, stride); });
            return out;
          },
          "out"_a,
          "Writes the positions (m) into an array (N, 3) of float32 or float64, without an allocation, and returns it. "
          "It may\n"
          "be a view of three columns of a longer array, such as `vertices[:, :3]`.")
      .def(
          "copy_velocities",
          [](PySimulation& s, const py::array& out) {
            copy_into(s, out, "copy_velocities",
                      [](const Simulation& of, auto* to, std::size_t stride) { of.copy_velocities(to, stride); });
            return out;
          },
          "out"_a, "The same with the velocities (m/s).")
      .def(
          "copy_normals",
          [](PySimulation& s, const py::array& out) {
            copy_into(s, out, "copy_normals",
                      [](const Simulation& of, auto* to, std::size_t stride) { of.copy_normals(to, stride); });
            return out;
          },
          "out"_a,
          "The same with unit normals: means over the faces around a particle by area; (0, 0, 0) where there is none.")
      .def(
          "set_forces",
          [](PySimulation& s, const py::object& given) {
            const std::vector<Vec3> forces = given.is_none() ? std::vector<Vec3>{} : rows_of(given, "forces");
            s.now()->set_forces(forces);
          },
          "forces"_a,
          "Sets the force on each particle, (N, 3) in N, which acts in every substep until others are set; None: no "
          "forces.\n"
          "save_state() and checkpoints do not contain them.")
      .def_property_readonly(
          "inverse_masses", [](PySimulation& s) { return array_of(s.now()->inverse_masses()); },
          "float64 (N,), 1/kg: 0 where a particle is held now, by a pin or by hand.")
      .def_property(
          "gravity", [](PySimulation& s) { return py::tuple(py::cast(s.now()->model().scene.gravity)); },
          [](PySimulation& s, const py::object& given) {
            const Vec3 g = vector_of(given, "gravity");
            s.compute([&](Simulation& of) { of.set_gravity(g); });
          },
          "(x, y, z), m/s^2. Assigning it takes a new set-up where levels are used, which are laid out for a weight.")
      .def_property(
          "wind",
          [](PySimulation& s) -> py::object {
            const std::optional<Wind> wind = s.now()->model().scene.wind;
            if (!wind) return py::none();
            return py::tuple(py::cast(wind->velocity));
          },
          [](PySimulation& s, const py::object& u) { s.now()->set_wind(vector_of(u, "wind")); },
          "The velocity of the air (x, y, z), m/s; None in a scene without wind, where it cannot be assigned.")
      .def_property_readonly(
          "faces", [](PySimulation& s) { return array_of(s.now()->model().render_mesh.faces); },
          "int32 (F, 4), particles; -1 ends a triangle. A copy. Tears and cuts change it.")
      .def_property_readonly(
          "triangles",
          [](PySimulation& s) {
            return array_of(triangles(Mesh{{}, s.now()->model().render_mesh.faces, {}, {}}));
          },
          "int32 (T, 3), particles: the faces, quads as two.")
      .def_property_readonly(
          "lines", [](PySimulation& s) { return array_of(s.now()->model().render_mesh.lines); },
          "int32 (L, 2), particles: edges that belong to no face.")
      .def_property_readonly("bodies", &bodies_of, "A list of Body, in the scene's order.")
      .def_property(
          "scene", [](PySimulation& s) { return Scene(s.now()->scene()); },
          [](PySimulation& s, const py::object& given) {
            const Scene scene = scene_of(given, py::none());
            s.compute([&](Simulation& of) { of.set_scene(scene); });
          },
          "The scene, with the gravity and wind that were set last. Assign another one to change masses, stiffness,\n"
          "compliance, moduli and other settings between steps, and to add and remove bodies and objects: bodies of "
          "the\n"
          "same name and number of particles keep their state, and contacts of what stays what they remember. All is\n"
          "laid out anew, which takes as long as the set-up; the same scene changes nothing, to the bit.")
      .def_property_readonly(
          "state_hash", [](PySimulation& s) { return hex(s.now()->state_hash()); },
          "16 hexadecimal digits, as in report.json: equal runs have equal hashes.");
}

void add_hand(Class& simulation) {
  simulation
      .def(
          "move_pins",
          [](PySimulation& s, const py::object& particles, const py::object& to) {
            const std::vector<int> which = integers_of(particles, "move_pins: particles");
            s.now()->move_pins(which, rows_of(to, "move_pins: to"));
          },
          "particles"_a, "to"_a,
          "Moves pinned particles (K,) to positions (K, 3) in m, between two steps. Raises InputError, and moves "
          "none,\n"
          "for one that is not pinned or that keyframes move.")
      .def(
          "set_pose",
          [](PySimulation& s, const std::string& object, const py::object& translate, const py::object& axis,
             double degrees, const py::object& matrix) {
            const RigidPose pose = pose_of(translate, axis, degrees, matrix);
            s.compute([&](Simulation& of) { of.set_pose(object, pose); });
          },
          "object"_a, "translate"_a = py::none(), "axis"_a = py::none(), "degrees"_a = 0.0, "matrix"_a = py::none(),
          "Moves an object of the environment: during the next step it goes from where it is to a rotation by degrees\n"
          "about an axis (the y axis unless named) and a translation (m), or to a matrix (4, 4) of both, and rests "
          "there\n"
          "until the next call. This replaces its \"motion\".")
      .def(
          "set_vertices",
          [](PySimulation& s, const std::string& object, const py::object& positions) {
            const std::vector<Vec3> x = rows_of(positions, "set_vertices: positions");
            s.compute([&](Simulation& of) { of.set_vertices(object, x); });
          },
          "object"_a, "positions"_a,
          "Moves the vertices of an object whose \"animation\" is {\"from_code\": true}: during the next step each "
          "goes\n"
          "straight to its position, (V, 3) in m in the order of the object's mesh, and rests there until the next "
          "call.")
      .def(
          "hold",
          [](PySimulation& s, int particle, const py::object& to) {
            to.is_none() ? s.now()->hold(particle) : s.now()->hold(particle, vector_of(to, "hold: to"));
          },
          "particle"_a, "to"_a = py::none(),
          "Holds a particle where it is, or at a position (m) to which the next step moves it. Needs interactive=True.")
      .def(
          "pull",
          [](PySimulation& s, int particle, const py::object& to, double compliance) {
            s.now()->pull(particle, vector_of(to, "pull: to"), compliance);
          },
          "particle"_a, "to"_a, "compliance"_a,
          "Pulls a particle to a position (m) by a spring of this compliance (m/N). Needs interactive=True.")
      .def(
          "release", [](PySimulation& s, int particle) { s.now()->release(particle); }, "particle"_a,
          "Releases a particle that hold() or pull() took.")
      .def("handles", &handle_dicts, "The particles that are held or pulled: a list of dicts.")
      .def(
          "cut", [](PySimulation& s, const py::object& edges) { return s.now()->cut(edges_of(edges)); }, "edges"_a,
          "Cuts bodies that name \"tear\" along edges (E, 2), particles (left, right) of the knife. Returns how many\n"
          "vertices were split: each is one more particle, the last of its body.")
      .def(
          "wake", [](PySimulation& s) { s.now()->wake(); }, "Ends the scene's sleep, if it sleeps.");
}

void add_results(Class& simulation) {
  simulation
      .def(
          "measure",
          [](PySimulation& s) {
            return parsed(
                s.compute([](const Simulation& of) { return measures_json(of.model(), of.solver(), of.times()); }));
          },
          "A dict of strain, momenta, energies, contacts and more, with the names and units of \"state\" in "
          "report.json.")
      .def(
          "report", [](PySimulation& s, const std::optional<std::string>& status) { return parsed(s.report(status)); },
          "status"_a = py::none(),
          "The contents of report.json as a dict; its \"status\" is \"running\", \"diverged\", or the argument.")
      .def(
          "warnings", [](PySimulation& s) { return warnings(s.now()->model()); },
          "A list of lines: settings beyond a boundary at which a method is known to fail. Empty: none is known.")
      .def(
          "plan", [](PySimulation& s) { return parsed(plan_json(*s.now())); },
          "A dict of what runs: solver, constraints, colours, launches a step, memory by owner.")
      .def(
          "plan_text", [](PySimulation& s) { return plan(*s.now()); }, "What `malha plan` prints.")
      .def(
          "failed_expectations",
          [](PySimulation& s) { return s.compute([](const Simulation& of) { return of.failed_expectations(); }); },
          "The expectations of the scene (\"expect\") that the present state does not meet, a line each.")
      .def(
          "constraint_values",
          [](PySimulation& s, std::size_t index) {
            if (index >= s.constraints.size()) throw py::index_error("constraint_values: no such constraint");
            return array_of(s.compute([&](const Simulation& of) { return of.constraint_values(index); }));
          },
          "index"_a = 0, "float64 (M,): C of each constraint of constraints[index] in the present state.")
      .def(
          "save_checkpoint",
          [](PySimulation& s, const std::filesystem::path& path) {
            s.compute([&](const Simulation& of) { of.save_checkpoint(path.string()); });
          },
          "path"_a,
          "Writes everything that the next step depends on, except what save_state() leaves out, completely or not at "
          "all.")
      .def(
          "load_checkpoint",
          [](PySimulation& s, const std::filesystem::path& path) { s.load_checkpoint(path.string()); }, "path"_a,
          "Continues from a checkpoint of the same scene with the same bits. Raises InputError for another one.")
      .def(
          "save_state",
          [](PySimulation& s) { return py::bytes(s.compute([](const Simulation& of) { return of.save_state(); })); },
          "Everything that the next step depends on, as bytes, except handles, gravity, wind and pins.")
      .def("restore_state", &PySimulation::restore_state, "state"_a,
           "Restores what save_state() returned for the same scene; the same bits follow.");
}

}  // namespace

void add_simulation(py::module_& module) {
  py::class_<BodyOf>(module, "Body", "A body of a simulation, with its particles and faces.")
      .def_readonly("name", &BodyOf::name, "As in the scene.")
      .def_property_readonly(
          "particles", [](const BodyOf& b) { return slice(b.first, b.end); }, "A slice of Simulation.positions.")
      .def_property_readonly(
          "faces", [](const BodyOf& b) { return slice(b.first_face, b.end_face); }, "A slice of Simulation.faces.")
      .def_property_readonly(
          "vertices", [](const BodyOf& b) { return array_of(b.vertices); },
          "int32 (V,): the particle that each vertex of its mesh is, -1 where nothing uses it. After\n"
          "them come the particles that tearing added.")
      .def("__repr__", [](const BodyOf& b) {
        return "<malha.Body '" + b.name + "', " + counted(static_cast<std::size_t>(b.end - b.first), "particle") + ">";
      });
  Class simulation(
      module, "Simulation", py::custom_type_setup(&collect_cycles<PySimulation, visit, clear>),
      "A scene that is simulated step by step. One thread at a time may use it; several may each have one.");
  simulation
      .def(
          py::init<const py::object&, int, const std::string&, const std::string&, bool, bool, bool,
                   const py::object&>(),
          "scene"_a, py::kw_only(), "threads"_a = 0, "backend"_a = "openmp", "machine"_a = "cpu",
          "adaptive_threads"_a = true, "timed_passes"_a = false, "interactive"_a = false, "constraints"_a = py::tuple(),
          "scene: a Scene, or what makes one. threads: 0 for as many as there are. backend: \"openmp\" or \"serial\",\n"
          "with the same bits. machine: the one that patches are cut for, as of `malha run --for`.\n"
          "adaptive_threads: whether steps run on one thread while other programs make that faster; if not, a number "
          "of\n"
          "threads is kept. timed_passes: whether a device waits for each pass, to time it in the report; a host "
          "always\n"
          "times them. interactive: whether hold() and pull() are wanted. constraints: of your own, Constraint "
          "objects.\n"
          "Raises InputError for what cannot be simulated.")
      .def(
          "step",
          [](const py::object& self, long long n, const py::object& callback) {
            return self.cast<PySimulation&>().step(self, n, callback);
          },
          "n"_a = 1, "callback"_a = py::none(),
          "Advances by n steps of the scene's dt, and returns how many were done. callback(simulation) is called "
          "after\n"
          "each step, and ends the loop where what it returns is false (but None goes on). Ctrl-C raises "
          "KeyboardInterrupt after a whole step.\n"
          "Other threads of Python run meanwhile. Raises Diverged.")
      .def(
          "trace_step",
          [](const py::object& self) {
            py::list all;
            for (const auto& [kernel, launches, items] : self.cast<PySimulation&>().trace_step(self))
              all.append(py::dict("kernel"_a = kernel, "launches"_a = launches, "items"_a = items));
            return all;
          },
          "Advances by one step, and returns the kernels that it launched: a list of dicts of kernel, launches and "
          "items.")
      .def("__repr__", [](PySimulation& s) {
        const auto use = s.now();
        return "<malha.Simulation '" + use->model().scene.name + "', " + counted(use->model().x.size(), "particle") +
               ", " + shown(use->time()) + " s>";
      });
  add_state(simulation), add_hand(simulation), add_results(simulation);
}

}  // namespace malha::python
