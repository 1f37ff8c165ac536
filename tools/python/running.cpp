// SPDX-License-Identifier: Apache-2.0
#include "tools/python/running.h"

#include "tools/python/arrays.h"
#include "tools/python/constraint.h"
#include "tools/python/interrupts.h"
#include "tools/python/scene.h"

namespace malha::python {

namespace py = pybind11;

SimulationOptions options_of(int threads, const std::string& backend) {
  if (threads < 0 || threads > 1024)
    refuse("simulation", "threads", std::to_string(threads), "0 for as many as there are, or 1 to 1024");
  SimulationOptions options;
  options.threads = threads, options.adaptive_threads = true;
  options.backend = backend_named(backend);
  return options;
}

bool ends_loop(const py::object& said) {
  if (said.is_none()) return false;
  const int truth = PyObject_IsTrue(said.ptr());
  if (truth < 0) throw py::error_already_set();
  return truth == 0;
}

PySimulation::PySimulation(const py::object& scene, int threads, const std::string& backend, const std::string& machine,
                           bool adaptive_threads, bool timed_passes, bool interactive, const py::object& given) {
  const Scene of = scene_of(scene, py::none());
  SimulationOptions options = options_of(threads, backend);
  options.machine = machine, options.interactive = interactive;
  options.adaptive_threads = adaptive_threads, options.timed_passes = timed_passes;
  for (const py::handle one : given) {
    if (!py::isinstance<PythonConstraint>(one))
      refuse("simulation", "constraints", malha::quoted(type_of(one)), "a list of malha.Constraint");
    options.constraints.push_back(one.cast<const PythonConstraint&>().definition);
    constraints.append(one);
  }
  {
    const Shutdown::Guard inside;
    const py::gil_scoped_release release;
    simulation_.emplace(of, options);
  }
  for (const py::handle one : constraints)
    if (const auto& constraint = one.cast<const PythonConstraint&>(); constraint.check)
      check_gradients(constraint.definition, simulation_->positions());
}

long long PySimulation::step(const py::object& self, long long n, const py::object& callback) {
  if (n < 0) refuse("step", "n", std::to_string(n), "0 or more");
  if (diverged_) throw Diverged(*diverged_ + "; restore_state(), load_checkpoint() or new positions let it go on");
  const Shutdown::Guard inside;
  SignalPolling interrupts;
  long long done = 0;
  try {
    while (done < n) {
      compute([&](Simulation& simulation) {
        do simulation.step(), ++done;
        while (done < n && callback.is_none() && !interrupts.is_due() && !Shutdown::is_pending());
      });
      Shutdown::exit_thread_if_pending();
      if (!callback.is_none() && ends_loop(callback(self))) break;
      interrupts.poll();
    }
  } catch (const Diverged& error) {
    diverged_ = error.what();
    throw;
  }
  return done;
}

std::vector<Launches> PySimulation::trace_step(const py::object& self) {
  const LaunchTrace trace;
  step(self, 1, py::none());
  return trace.list();
}

std::string PySimulation::report(const std::optional<std::string>& status) {
  std::vector<std::string> notes;
  if (diverged_) notes.push_back(*diverged_);
  const std::string word = diverged_ ? "diverged" : status.value_or("running");
  return compute([&](const Simulation& simulation) { return simulation.report(word, notes); });
}

void PySimulation::restore_state(const py::bytes& state) {
  const auto bytes = static_cast<std::string>(state);
  compute([&](Simulation& simulation) { simulation.restore_state(bytes); });
  diverged_.reset();
}
void PySimulation::load_checkpoint(const std::string& path) {
  compute([&](Simulation& simulation) { simulation.load_checkpoint(path); });
  diverged_.reset();
}
void PySimulation::set_positions(const std::vector<Vec3>& x) {
  compute([&](Simulation& simulation) { simulation.set_positions(x); });
  diverged_.reset();
}

}  // namespace malha::python
