// SPDX-License-Identifier: Apache-2.0
// malha.Constraint: a user constraint with a Python function.
#pragma once
#include <pybind11/pybind11.h>

#include <memory>

#include "malha/user_constraint.h"
#include "tools/python/initialised.h"

namespace malha::python {

/// A Python function that threads may copy and release without holding the interpreter.
using Function = std::shared_ptr<pybind11::object>;

struct PythonConstraint {
  UserConstraint definition;
  Function function;  // the one that `definition` calls
  bool check = false;
};

/// Makes objects of a class visible to Python's cycle collector. `visit` and `clear` are called for initialised
/// objects.
template <class T, int (*visit)(T&, visitproc, void*), void (*clear)(T&)>
void collect_cycles(PyHeapTypeObject* heap) {
  static const auto held = [](PyObject* self) -> T* {
    const auto place = reinterpret_cast<pybind11::detail::instance*>(self)->get_value_and_holder();
    return place.holder_constructed() ? static_cast<T*>(place.value_ptr()) : nullptr;
  };
  PyTypeObject& type = heap->ht_type;
  type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type.tp_traverse = [](PyObject* self, visitproc visitor, void* argument) -> int {
    if (const int found = visitor(reinterpret_cast<PyObject*>(Py_TYPE(self)), argument)) return found;
    T* const of = held(self);
    return of ? visit(*of, visitor, argument) : 0;
  };
  type.tp_clear = [](PyObject* self) -> int {
    if (T* const of = held(self)) clear(*of);
    return 0;
  };
}

void add_constraint(pybind11::module_& module);

}  // namespace malha::python

namespace pybind11::detail {
template <>
class type_caster<malha::python::PythonConstraint>
    : public malha::python::InitialisedCaster<malha::python::PythonConstraint> {};
}  // namespace pybind11::detail
