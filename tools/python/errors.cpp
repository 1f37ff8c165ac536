// SPDX-License-Identifier: Apache-2.0
#include "tools/python/errors.h"

#include <string>

#include "malha/error.h"

namespace malha::python {

namespace py = pybind11;

namespace {

// Static, because an exception translator has no state; they live as long as the interpreter.
PyObject *input_error = nullptr, *out_of_memory = nullptr, *diverged = nullptr;

PyObject* new_exception(py::module_& module, const char* name, const char* doc, const py::object& bases) {
  const std::string full = std::string("malha.") + name;
  PyObject* error = PyErr_NewExceptionWithDoc(full.c_str(), doc, bases.ptr(), nullptr);
  if (!error) throw py::error_already_set();
  module.add_object(name, error);
  return error;
}

}  // namespace

void add_errors(py::module_& module) {
  const auto builtin = [](PyObject* type) { return py::reinterpret_borrow<py::object>(type); };
  input_error =
      new_exception(module, "InputError",
                    "Input that was refused: the place, what was found and what is allowed, as the command says it.",
                    py::make_tuple(builtin(PyExc_ValueError)));
  out_of_memory = new_exception(module, "OutOfMemory", "Input that asks for more memory than there is.",
                                py::make_tuple(builtin(input_error), builtin(PyExc_MemoryError)));
  diverged = new_exception(
      module, "Diverged",
      "A run that became non-finite or exploded: at which step, and where. Of its simulation only report() "
      "makes sense afterwards.",
      py::make_tuple(builtin(PyExc_ArithmeticError)));
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(thrown);
    } catch (const OutOfMemory& error) {
      PyErr_SetString(out_of_memory, error.what());
    } catch (const InputError& error) {
      PyErr_SetString(input_error, error.what());
    } catch (const Diverged& error) {
      PyErr_SetString(diverged, (std::string("diverged at ") + error.what()).c_str());
    }
  });
}

}  // namespace malha::python
