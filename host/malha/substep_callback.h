// SPDX-License-Identifier: Apache-2.0
// Callback of a step at the end of each of its substeps.
#pragma once
#include <functional>

namespace malha {

/// Called at the end of each substep with its number in the step, from 1, and the simulated time (s). During the call
/// Simulation::positions() and velocities() return the state of the substep. The callback may call set_pose(),
/// set_vertices() and set_forces(), and must not change the simulation otherwise.
using SubstepCallback = std::function<void(int substep, double time)>;

}  // namespace malha
