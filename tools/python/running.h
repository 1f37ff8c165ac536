// SPDX-License-Identifier: Apache-2.0
// A simulation that Python holds: who may use it when, and what of Python it holds.
#pragma once
#include <pybind11/pybind11.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "malha/simulation.h"
#include "tools/python/initialised.h"
#include "tools/python/leaving.h"

namespace malha::python {

class Running {
 public:
  Running(const pybind11::object& scene, int threads, const std::string& backend, bool interactive,
          const pybind11::object& constraints);

  /// The simulation for one use, between steps. Nobody else gets it meanwhile: neither another thread nor what the use
  /// calls, as a constraint's function does.
  class Use {
   public:
    explicit Use(Running& of) : of_(of) {
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
    Running& of_;
  };
  Use now() { return Use(*this); }

  /// work(simulation), without the interpreter: other threads of Python run meanwhile.
  template <class Work>
  auto compute(const Work& work) {
    const Use use = now();
    const Leaving::Inside inside;
    const pybind11::gil_scoped_release release;
    return work(*use);
  }

  /// At most n steps, fewer where `callback` returns what is false and not None: how many.
  long long step(const pybind11::object& self, long long n, const pybind11::object& callback);

  std::string report(const std::optional<std::string>& status);
  void restore_state(const pybind11::bytes& state);
  void load_checkpoint(const std::string& path);
  void set_positions(const std::vector<Vec3>& x);

  pybind11::list constraints;  // which C++ shares with them; visited by Python's collector

 private:
  std::optional<Simulation> simulation_;
  bool in_use_ = false;                  // read and written by who holds the interpreter
  std::optional<std::string> diverged_;  // what was said then
};

/// Whether a callback that gave this ends the loop: False does, numpy's too, and None does not.
bool ends(const pybind11::object& said);

/// SimulationOptions of these words. Throws InputError for others.
SimulationOptions options_of(int threads, const std::string& backend);

}  // namespace malha::python

namespace pybind11::detail {
template <>
class type_caster<malha::python::Running> : public malha::python::InitialisedCaster<malha::python::Running> {};
}  // namespace pybind11::detail
