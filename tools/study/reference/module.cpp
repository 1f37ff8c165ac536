// SPDX-License-Identifier: Apache-2.0
// The Python module _malha_reference: equations of motion and integrators with which the studies compare malha.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <functional>

#include "host/base/stopwatch.h"
#include "tools/study/reference/chain.h"
#include "tools/study/reference/elastica.h"
#include "tools/study/reference/steps.h"
#include "tools/study/reference/sweep.h"
#include "tools/study/reference/tetrahedra.h"

namespace malha::study {

namespace {

namespace py = pybind11;
using namespace py::literals;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

Rows rows(const Vector& flat) { return Rows::Map(flat.data(), flat.size() / 3, 3); }

/// The coordinates of one point for each particle. Throws for another number of points.
Vector flat_of(const Rows& rows, const System& system) {
  if (rows.rows() != system.count())
    throw py::value_error("found an array (" + std::to_string(rows.rows()) + ", 3); allowed: (" +
                          std::to_string(system.count()) + ", 3), a row for each particle");
  return Vector::Map(rows.data(), rows.size());
}

std::unique_ptr<System> system_of(const std::string& json) {
  const Scene scene = parse_scene(json, "scene", "");
  if (scene.bodies.front().constraints.front().type == "neo_hookean") return tetrahedron_system(scene);
  return spring_system(scene);
}

py::dict conserved(const System& system, const Rows& x, const Rows& v) {
  const ConservedQuantities sum = conserved_quantities(system, {flat_of(x, system), flat_of(v, system)});
  return py::dict("kinetic"_a = sum.kinetic, "potential"_a = sum.potential, "elastic"_a = sum.elastic,
                  "energy"_a = sum.energy(), "momentum"_a = sum.momentum, "angular_momentum"_a = sum.angular_momentum);
}

const SpringSystem& springs_of(const System& system) {
  const auto* springs = dynamic_cast<const SpringSystem*>(&system);
  if (springs == nullptr) throw py::value_error("found tetrahedra; allowed: springs");
  return *springs;
}

const std::vector<int>& checked(const std::vector<int>& order, const SpringSystem& system) {
  const int count = static_cast<int>(system.springs.size());
  for (const int s : order)
    if (s < 0 || s >= count)
      throw py::value_error("found spring " + std::to_string(s) + "; allowed: 0 to " + std::to_string(count - 1));
  return order;
}

/// A plain sweep in float or double.
class Sweep {
 public:
  Sweep(const System& of, const std::optional<std::vector<int>>& order, const std::string& precision,
        double compliance) {
    const SpringSystem& system = springs_of(of);
    const auto make = [&]<class R>(R) {
      const auto sweep = std::make_shared<PlainSweep<R>>(
          system, order ? checked(*order, system) : order_by_colour(system), compliance);
      substep_ = [sweep](double h) { sweep->substep(h); };
      state_ = [sweep] { return sweep->state(); };
    };
    if (precision != "float" && precision != "double")
      throw py::value_error("found the precision \"" + precision + "\"; allowed: float, double");
    precision == "float" ? make(float()) : make(double());
  }

  void advance(double h, int substeps) {
    while (substeps-- > 0) substep_(h);
  }
  State state() const { return state_(); }

 private:
  std::function<void(double)> substep_;
  std::function<State()> state_;
};

/// A state that one of the integrators advances.
class Integrator {
 public:
  Integrator(const System& system, const std::string& method, const Rows& x, const Rows& v)
      : system_(system), method_(method), state_{flat_of(x, system), flat_of(v, system)} {
    if (method == "backward Euler") {
      const auto* springs = dynamic_cast<const SpringSystem*>(&system);
      if (springs == nullptr) throw py::value_error("backward Euler: found tetrahedra; allowed: springs");
      newton_ = std::make_unique<BackwardEuler>(*springs);
    } else if (method != "explicit Euler" && method != "symplectic Euler" && method != "RK4") {
      throw py::value_error("found the method \"" + method +
                            "\"; allowed: explicit Euler, symplectic Euler, RK4, backward Euler");
    }
  }

  double advance(double h, int steps) {
    return thread_seconds([&] {
      for (int k = 0; k < steps; ++k)
        if (newton_)
          newton_->step(h, state_);
        else
          (method_ == "RK4"                ? rk4
           : method_ == "symplectic Euler" ? symplectic_euler
                                           : explicit_euler)(system_, h, state_);
    });
  }

  Rows x() const { return rows(state_.x); }
  Rows v() const { return rows(state_.v); }
  long factorisations() const { return newton_ ? newton_->solves() : 0; }

 private:
  const System& system_;
  std::string method_;
  State state_;
  std::unique_ptr<BackwardEuler> newton_;  // null for other methods
};

}  // namespace

}  // namespace malha::study

PYBIND11_MODULE(_malha_reference, module) {
  using namespace malha::study;
  module.doc() =
      "Equations of motion of springs and tetrahedra, and integrators in double, with which the studies compare "
      "malha.\n"
      "They share the scene and its mesh with malha, no kernels and no solvers. SI units; N: particles of the scene.";

  py::class_<System>(module, "System",
                     "The equations of motion of a scene with one body, given as JSON text: springs for distance "
                     "constraints, all\nwith a compliance; second differences along rows and columns of a grid for "
                     "bending of a rigidity; or tetrahedra of\nthe stable neo-Hookean material.")
      .def(py::init(&system_of), "scene"_a)
      .def_property_readonly(
          "positions", [](const System& s) { return rows(s.start.x); }, "(N, 3), m: at the start.")
      .def_property_readonly(
          "velocities", [](const System& s) { return rows(s.start.v); }, "(N, 3), m/s: at the start.")
      .def_property_readonly(
          "pinned", [](const System& s) { return py::array(py::cast(s.pinned)); }, "(N,), bool.")
      .def("conserved", &conserved, "x"_a, "v"_a,
           "Energies (J) kinetic, potential (0 at the origin), elastic, and energy, their sum; momentum (3,), kg m/s, "
           "and\nangular_momentum (3,) about the origin, kg m^2/s; of the particles that are not pinned.")
      .def(
          "strains", [](const System& s, const Rows& x) { return s.strains(flat_of(x, s)); }, "x"_a,
          "(E,): length over rest length - 1 of each spring, or of each edge of the tetrahedra.")
      .def(
          "largest_frequency", [](const System& s) { return largest_frequency(s, s.start.x); },
          "omega_max of small motions about the start, rad/s: symplectic Euler is stable up to steps of 2 / omega_max.")
      .def(
          "equilibrium", [](const System& s, double tolerance) { return rows(relax_to_rest(s, tolerance)); },
          "tolerance"_a,
          "(N, 3), m: positions that damped motion from the start reaches, with accelerations below tolerance times "
          "gravity.");

  py::class_<Integrator>(module, "Integrator",
                         "Advances the state x (N, 3), m, and v (N, 3), m/s, of a System by \"explicit Euler\", "
                         "\"symplectic Euler\", \"RK4\" or\n\"backward Euler\" (of springs only, each step solved by "
                         "Newton's method).")
      .def(py::init<const System&, const std::string&, const Rows&, const Rows&>(), "system"_a, "method"_a, "x"_a,
           "v"_a, py::keep_alive<1, 2>())
      .def("advance", &Integrator::advance, "h"_a, "steps"_a,
           "Takes steps of h (s); returns the processor time of this thread, s.")
      .def_property_readonly("positions", &Integrator::x, "(N, 3), m.")
      .def_property_readonly("velocities", &Integrator::v, "(N, 3), m/s.")
      .def_property_readonly("factorisations", &Integrator::factorisations, "Number so far, of backward Euler.");

  py::class_<Sweep>(module, "PlainSweep",
                    "Position Based Dynamics of a System of springs: in each substep one sweep in one direction over "
                    "its springs, as hard\nconstraints or with a compliance (m/N). order: of the springs, by their "
                    "indices; by colours if not given.\nprecision: \"float\" or \"double\".")
      .def(py::init<const System&, const std::optional<std::vector<int>>&, const std::string&, double>(), "system"_a,
           "order"_a = py::none(), "precision"_a = "double", "compliance"_a = 0.0, py::keep_alive<1, 2>())
      .def("advance", &Sweep::advance, "h"_a, "substeps"_a, "Takes substeps of h (s).")
      .def_property_readonly(
          "positions", [](const Sweep& s) { return rows(s.state().x); }, "(N, 3), m.")
      .def_property_readonly(
          "velocities", [](const Sweep& s) { return rows(s.state().v); }, "(N, 3), m/s.");

  module.def(
      "order_from_pins", [](const System& s) { return order_from_pins(springs_of(s)); }, "system"_a,
      "The indices of all springs in order of their nearer end's graph distance from the pins.");
  module.def(
      "order_by_colour", [](const System& s) { return order_by_colour(springs_of(s)); }, "system"_a,
      "The indices of all springs by greedy colouring: springs of a colour have no particle in common.");
  module.def(
      "amplification_of_sweep",
      [](const System& s, const std::vector<int>& order) {
        const SpringSystem& system = springs_of(s);
        return amplification_of_sweep(linearised_sweep(system, checked(order, system)));
      },
      "system"_a, "order"_a,
      "The factor by which a substep with a sweep over hard constraints in this order multiplies small motions about "
      "rest:\nthe spectral radius of y' = T (2 y - previous y), from the eigenvalues of the linearised sweep T.");

  py::class_<ReferenceChain>(module, "Chain",
                             "An inextensible chain of `length` (m) and equal links, pinned at its first joint and "
                             "released from the horizontal.\nAll joints have equal masses except the last, which has "
                             "half of it. SHAKE in double, each step solved by Newton's method.")
      .def(py::init<int, double, double>(), "links"_a, "length"_a, "gravity"_a)
      .def(
          "advance",
          [](ReferenceChain& c, double h, int n) {
            while (n-- > 0) c.step(h);
          },
          "h"_a, "steps"_a, "Takes steps of h (s).")
      .def_property_readonly(
          "joints",
          [](const ReferenceChain& c) {
            Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> all(c.joints().size(), 2);
            for (std::size_t i = 0; i < c.joints().size(); ++i) all.row(i) << c.joints()[i][0], c.joints()[i][1];
            return all;
          },
          "(links + 1, 2), m: upwards, and away from the first joint.")
      .def_property_readonly("kinetic", &ReferenceChain::kinetic,
                             "J, for a total mass of 1 kg, at the middle of the last step.")
      .def_property_readonly("potential", &ReferenceChain::potential, "J, 0 at the start.");

  module.def(
      "heavy_elastica",
      [](double gamma, int points) {
        Rows line(points + 1, 3);
        for (Eigen::Index k = 0; const ElasticaPoint& p : heavy_elastica(gamma, points))
          line.row(k++) << p.reach, p.drop, p.slope;
        return line;
      },
      "gamma"_a, "points"_a,
      "(points + 1, 3): reach, drop (both over the length) and slope (rad) of evenly spaced points of a line that "
      "leaves a "
      "clamp\nhorizontally and bends under its weight; gamma: density g L^3 / D, up to 1000.");
}
