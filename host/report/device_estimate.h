// SPDX-License-Identifier: Apache-2.0
// What a step asks of the machine that a model is laid out for, before it runs there.
#pragma once
#include <string>
#include <vector>

#include "host/model/machine.h"
#include "host/patch/patch_plan.h"
#include "malha/simulation.h"

namespace malha {

/// Of the visits of a step: how the particles and constraints travel between memory and cores.
struct SolveTraffic {
  double particle_bytes = 0, constraint_bytes = 0;
};

/// Each visit reads what it needs once, whether it goes one way or both, and writes what it changes once. `plan`: the
/// model's patches.
SolveTraffic solve_traffic(const Model& model, const Solver& solver, const PatchPlan& plan);

/// What a step asks of a machine.
struct DeviceEstimate {
  Machine machine;
  int phases = 0, groups_fewest = 0, groups_most = 0;  // a phase; no phases: no batched constraints, and all is 0
  int at_once = 0;                                     // groups that the machine works on
  double group_bytes = 0;                              // of fast memory, at most
  std::size_t launches = 0;
  bool launches_at_least = false;
  bool replays = false;  // a device records them once
  SolveTraffic moved{};
  double bytes_per_second = 0;             // of the machine's memory; measured where its facts are not known
  std::vector<std::string> not_counted{};  // passes beside the visits, whose bytes are not in `moved`
  /// For fast memory: then no group uses it.
  bool is_too_large() const { return machine.fast_bytes > 0 && group_bytes > double(machine.fast_bytes); }
  double ms() const { return (moved.particle_bytes + moved.constraint_bytes) / bytes_per_second * 1000; }
};
DeviceEstimate plan_for(const Simulation& simulation, const Machine& machine);

/// For people.
std::string list_demand(const DeviceEstimate& demand);

}  // namespace malha
