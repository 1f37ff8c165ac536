// SPDX-License-Identifier: Apache-2.0
// Errors of malha as Python exceptions, with the messages of the command line.
#pragma once
#include <pybind11/pybind11.h>

namespace malha::python {

/// Adds malha.InputError, malha.OutOfMemory and malha.Diverged.
void add_errors(pybind11::module_& module);

}  // namespace malha::python
