// SPDX-License-Identifier: Apache-2.0
#include "tools/python/constraint.h"

#include <algorithm>
#include <string>

#include "tools/python/arrays.h"

namespace malha::python {

namespace py = pybind11;
using namespace py::literals;

namespace {

Function shared(const py::object& function) {
  return {new py::object(function), [](py::object* held) {
            const py::gil_scoped_acquire hold;
            delete held;
          }};
}

/// Converts the result of a function to an array of this shape.
Doubles result_array(const py::handle& value, const std::string& name, const char* what,
                     const std::vector<py::ssize_t>& shape) {
  const Doubles array = doubles_of(value);
  std::string wanted;
  for (const py::ssize_t n : shape) wanted += (wanted.empty() ? "(" : ", ") + std::to_string(n);
  wanted += shape.size() == 1 ? ",)" : ")";
  const bool fits = array && static_cast<std::size_t>(array.ndim()) == shape.size() &&
                    std::equal(shape.begin(), shape.end(), array.shape());
  if (!fits) refuse("constraint '" + name + "'", what, found_in(array), "an array " + wanted);
  return array;
}

/// Calls the function with new arrays each time, so that it may keep them.
void call(const py::object& function, const std::string& name, int arity, const UserBatch& batch) {
  const py::gil_scoped_acquire hold;
  const py::ssize_t count = batch.count, k = arity;
  const py::array_t<double> x({count, k, py::ssize_t{3}}, batch.x->data());
  const py::array_t<int> number(count, batch.index);
  const py::object result = function(x, number);
  if (!py::isinstance<py::tuple>(result) || py::len(result) != 2)
    refuse("constraint '" + name + "'", "", "a function that gives no pair", "one that gives (C, gradient)");
  const auto pair = result.cast<py::tuple>();
  const Doubles C = result_array(pair[0], name, "C", {count}),
                gradient = result_array(pair[1], name, "gradient", {count, k, 3});
  std::copy_n(C.data(), count, batch.C);
  std::copy_n(gradient.data(), count * k * 3, batch.gradient->data());
}

PythonConstraint make_constraint(const py::object& particles, const py::object& function, double compliance,
                                 const std::string& name, bool check) {
  const auto wrong = [&](const char* what, const std::string& found, const char* allowed) {
    refuse("constraint '" + name + "'", what, found, allowed);
  };
  if (!PyCallable_Check(function.ptr()))
    wrong("function", "a value of type " + type_of(function), "a function (x, which)");
  if (!(compliance >= 0 && compliance <= 1e300)) wrong("compliance", shown(compliance), "numbers >= 0");
  const py::array array = numbers_of(particles, true);
  if (!array && py::array::ensure(particles))
    wrong("particles", "what is no array of whole numbers", "an array (M, k)");
  PyErr_Clear();
  if (!array || array.ndim() != 2 || array.shape(1) < 1) wrong("particles", found_in(array), "an array (M, k)");
  PythonConstraint constraint;
  constraint.check = check;
  UserConstraint& definition = constraint.definition;
  definition.name = name, definition.arity = static_cast<int>(array.shape(1)), definition.compliance = compliance;
  definition.particles = integers_of(array, "particles");
  constraint.function = shared(function);
  definition.evaluate = [held = constraint.function, name, arity = definition.arity](const UserBatch& batch) {
    call(*held, name, arity, batch);
  };
  return constraint;
}

int visit(PythonConstraint& constraint, visitproc visitor, void* argument) {
  return visitor(constraint.function->ptr(), argument);
}
void clear(PythonConstraint& constraint) { *constraint.function = py::none(); }

}  // namespace

void add_constraint(py::module_& module) {
  py::class_<PythonConstraint>(
      module, "Constraint", py::custom_type_setup(&collect_cycles<PythonConstraint, visit, clear>),
      "A user-defined constraint C(x) = 0, to try an idea. It is slow: the function is called for every batch of\n"
      "constraints that share no particle, in every iteration of every substep. A kernel takes nanoseconds instead.")
      .def(
          py::init(&make_constraint), "particles"_a, "function"_a, "compliance"_a = 0.0, "name"_a = "user",
          "check"_a = false,
          "particles: whole numbers (M, k), the particles of each constraint, as in Simulation.positions.\n"
          "function(x, which): x is (B, k, 3) in m, a batch of B constraints; which is (B,), their rows in particles.\n"
          "It returns C (B,) and its gradient (B, k, 3). It must depend on its arguments alone, or runs differ.\n"
          "compliance: XPBD's alpha, >= 0; C^2 / (2 alpha) is an energy in J. 0: as stiff as the iterations make it.\n"
          "check: compare the gradient with finite differences where a simulation starts.")
      .def(
          "check",
          [](const PythonConstraint& constraint, const py::object& positions, double tolerance) {
            check_gradients(constraint.definition, rows_of(positions, "positions"), tolerance);
          },
          "positions"_a, "tolerance"_a = 1e-4,
          "Compares the gradient with central differences at positions (N, 3), m. Raises InputError where one is off "
          "by\n"
          "more than tolerance times the constraint's largest, and says which.")
      .def_property_readonly(
          "name", [](const PythonConstraint& constraint) { return constraint.definition.name; },
          "For messages, plans and reports.")
      .def_property_readonly(
          "compliance", [](const PythonConstraint& constraint) { return constraint.definition.compliance; },
          "XPBD's alpha, >= 0.")
      .def("__len__", [](const PythonConstraint& constraint) {
        return constraint.definition.particles.size() / static_cast<std::size_t>(constraint.definition.arity);
      });
}

}  // namespace malha::python
