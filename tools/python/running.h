// A simulation that Python holds: who may use it when, and what of Python it holds.
#pragma once
#include <pybind11/pybind11.h>

#include <optional>
#include <stdexcept>
#include <string>

#include "host/simulation.h"

namespace malha::python {

class Running {
 public:
  Running(const pybind11::object& scene, int threads, const std::string& backend, bool by_hand,
          const pybind11::object& constraints);

  /// Between steps. Throws while another thread computes, or its own constraint's function asks.
  Simulation& now() {
    if (computing_)
      throw std::runtime_error(
          "simulation: found a step that is not done yet, by another thread or around this "
          "constraint's function; allowed: to use it between steps");
    return *simulation_;
  }

  /// Calls work(simulation) without the interpreter: other threads of Python run meanwhile.
  template <class Work>
  void compute(const Work& work) {
    Simulation& simulation = now();
    const InUse in_use(computing_);
    const pybind11::gil_scoped_release release;
    work(simulation);
  }

  /// At most n steps, fewer where `callback` returns False: how many.
  long long step(const pybind11::object& self, long long n, const pybind11::object& callback);

  std::string report(const std::optional<std::string>& status);
  void go_back(const pybind11::bytes& state);
  void load_checkpoint(const std::string& path);

  pybind11::list constraints;  // which C++ shares with them; visited by Python's collector

 private:
  struct InUse {
    explicit InUse(bool& of) : flag(of) { flag = true; }
    ~InUse() { flag = false; }
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;
    bool& flag;
  };
  std::optional<Simulation> simulation_;
  bool computing_ = false;               // read and written by who holds the interpreter
  std::optional<std::string> diverged_;  // what was said then
};

/// SimulationOptions of these words. Throws InputError for others.
SimulationOptions options_of(int threads, const std::string& backend);

}  // namespace malha::python
