// SPDX-License-Identifier: Apache-2.0
// The extension of the Python module malha: malha.py takes over all its names, and adds those that need no C++.
#include <pybind11/pybind11.h>

#include "host/base/build_info.h"
#include "tools/python/arguments.h"
#include "tools/python/constraint.h"
#include "tools/python/errors.h"
#include "tools/python/scene.h"
#include "tools/python/shutdown.h"
#include "tools/python/simulation.h"

PYBIND11_MODULE(_malha, module) {
  module.attr("__name__") = "malha";  // the module that classes, messages and pickles name
  module.doc() =
      "Deformable bodies by Position Based Dynamics with XPBD's compliance, and by Desbrun's method. SI units.\n"
      "A Scene says what is simulated, a Simulation steps through it, and arrays are numpy's.";
  module.attr("__version__") = malha::version();
  malha::python::add_errors(module);
  malha::python::add_scene(module);
  malha::python::add_constraint(module);
  malha::python::add_simulation(module);
  malha::python::add_run(module);
  malha::python::refuse_arguments_briefly(module);
  pybind11::module_::import("atexit").attr("register")(
      pybind11::cpp_function(&malha::python::Shutdown::wait_for_threads));
  module.attr("__name__") = "_malha";
}
