// SPDX-License-Identifier: Apache-2.0
// Backend of a benchmark, and the machine that its patches are planned for.
#pragma once
#include <string>

#include "host/solver/solver.h"
#include "malha/simulation.h"

namespace malha::bench {

struct RunsOn {
  std::string backend = "openmp";
  std::string machine = {};  // see SimulationOptions; empty: "cpu"

  bool is_device() const { return backend == "cuda"; }

  /// Throws InputError if there is no such device. To be called before the first measurement.
  void require_device() const {
    if (is_device()) require_cuda();
  }

  /// `time_passes`: whether each pass is timed, or whole steps only.
  SimulationOptions simulation_options(int threads, bool time_passes) const {
    SimulationOptions options{.threads = threads, .backend = backend_named(backend), .timed_passes = time_passes};
    if (!machine.empty()) options.machine = machine;
    return options;
  }
};

}  // namespace malha::bench
