// SPDX-License-Identifier: Apache-2.0
// Where the lines of a benchmark run, and what they are laid out for.
#pragma once
#include <string>

#include "host/solver/solver.h"
#include "malha/simulation.h"

namespace malha::bench {

struct RunsOn {
  std::string backend = "openmp";
  std::string machine = {};  // see SimulationOptions; empty: "cpu"

  /// As options say it; empty where they are the common ones.
  std::string words() const {
    return (backend == "openmp" ? "" : " --backend " + backend) + (machine.empty() ? "" : " --for " + machine);
  }

  bool device() const { return backend == "cuda"; }

  /// Throws InputError where there is no such device: before anything is measured.
  void require() const {
    if (device()) require_cuda();
  }

  /// `passes`: whether those are timed, or whole steps alone.
  SimulationOptions options(int threads, bool passes) const {
    SimulationOptions options{.threads = threads, .backend = backend_named(backend), .timed_passes = passes};
    if (!machine.empty()) options.machine = machine;
    return options;
  }
};

}  // namespace malha::bench
