// SPDX-License-Identifier: Apache-2.0
// Estimate of the work of a step on the machine that a model's patches are cut for, before it runs there.
#pragma once
#include <string>
#include <vector>

#include "host/model/machine.h"
#include "host/patch/patch_plan.h"
#include "malha/simulation.h"

namespace malha {

/// Bytes that the patch solves of a step move between memory and cores.
struct PatchTraffic {
  double particle_bytes = 0, constraint_bytes = 0;
};

/// Counts the traffic of a step. Each patch solve loads its particles and constraints once, whether it sweeps in one
/// direction or both, and stores once what it changed. `plan`: the model's patches.
PatchTraffic patch_traffic(const Model& model, const Solver& solver, const PatchPlan& plan);

/// Launches, thread groups, fast memory and memory traffic of a step on a machine.
struct DeviceEstimate {
  Machine machine;
  int colours = 0, groups_fewest = 0, groups_most = 0;  // per colour; 0 without batched constraints
  int groups_at_once = 0;                               // groups that run concurrently
  double group_bytes = 0;                               // fast memory of the largest group
  std::size_t launches = 0;
  bool launches_at_least = false;
  bool replays = false;  // the launches are a recorded graph
  PatchTraffic traffic{};
  double bytes_per_second = 0;             // of the machine's memory; measured where no value is known
  std::vector<std::string> not_counted{};  // passes besides the patch solves, whose bytes are not in `traffic`
  /// Returns whether a group exceeds the fast memory; then no group uses it.
  bool is_too_large() const { return machine.fast_bytes > 0 && group_bytes > double(machine.fast_bytes); }
  double ms() const { return (traffic.particle_bytes + traffic.constraint_bytes) / bytes_per_second * 1000; }
};
DeviceEstimate estimate_device(const Simulation& simulation, const Machine& machine);

}  // namespace malha
