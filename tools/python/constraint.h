// SPDX-License-Identifier: Apache-2.0
// malha.Constraint: a constraint whose function is Python's.
#pragma once
#include <pybind11/pybind11.h>

#include <memory>

#include "malha/user_constraint.h"
#include "tools/python/initialised.h"

namespace malha::python {

/// Copies may be made and dropped by threads that do not hold the interpreter.
using Function = std::shared_ptr<pybind11::object>;

struct PythonConstraint {
  UserConstraint own;
  Function function;  // that of `own`
  bool check = false;
};

/// Lets Python's collector find cycles through objects of a class: `visit` and `clear` get what is held, if it is made.
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
