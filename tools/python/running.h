// SPDX-License-Identifier: Apache-2.0
// A simulation owned by Python: exclusive use, and references to Python objects.
#pragma once
#include <pybind11/pybind11.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/report/launches.h"
#include "malha/simulation.h"
#include "tools/python/initialised.h"
#include "tools/python/shutdown.h"

namespace malha::python {

class PySimulation {
 public:
  PySimulation(const pybind11::object& scene, int threads, const std::string& backend, const std::string& machine,
               bool adaptive_threads, bool timed_passes, bool interactive, const pybind11::object& constraints);

  /// Exclusive use of the simulation between steps. Neither another thread nor code called by the use, such as a
  /// constraint's function, can use it meanwhile.
  class Use {
   public:
    explicit Use(PySimulation& of) : of_(of) {
      if (of_.in_use_)
        throw std::runtime_error(
            "simulation: found a step or another use that is not done yet, by another thread or around this "
            "constraint's function; allowed: to use it between steps");
      of_.in_use_ = true;
    }
    ~Use() { of_.in_use_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    Simulation& operator*() const { return *of_.simulation_; }
    Simulation* operator->() const { return &*of_.simulation_; }

   private:
    PySimulation& of_;
  };
  Use now() { return Use(*this); }

  /// Calls work(simulation) without holding the interpreter, so that other threads of Python can run.
  template <class Work>
  auto compute(const Work& work) {
    const Use use = now();
    const Shutdown::Guard inside;
    const pybind11::gil_scoped_release release;
    return work(*use);
  }

  /// Takes n steps, fewer if `callback` returns a false value other than None; returns how many.
  long long step(const pybind11::object& self, long long n, const pybind11::object& callback);

  /// Takes a step; returns the kernels that it launched.
  std::vector<Launches> trace_step(const pybind11::object& self);

  std::string report(const std::optional<std::string>& status);
  void restore_state(const pybind11::bytes& state);
  void load_checkpoint(const std::string& path);
  void set_positions(const std::vector<Vec3>& x);

  pybind11::list constraints;  // shared with C++, and visited by Python's cycle collector

 private:
  std::optional<Simulation> simulation_;
  bool in_use_ = false;                  // accessed only while holding the interpreter
  std::optional<std::string> diverged_;  // message of the divergence
};

/// Returns whether this result of a callback ends the loop: False does, numpy's too, and None does not.
bool ends_loop(const pybind11::object& said);

/// Returns SimulationOptions. Throws InputError for values that are not allowed.
SimulationOptions options_of(int threads, const std::string& backend);

}  // namespace malha::python

namespace pybind11::detail {
template <>
class type_caster<malha::python::PySimulation> : public malha::python::InitialisedCaster<malha::python::PySimulation> {
};
}  // namespace pybind11::detail
