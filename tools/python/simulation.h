// SPDX-License-Identifier: Apache-2.0
// malha.Simulation, and malha.run, which writes a whole run to a folder.
#pragma once
#include <pybind11/pybind11.h>

namespace malha::python {

void add_simulation(pybind11::module_& module);
void add_run(pybind11::module_& module);

}  // namespace malha::python
