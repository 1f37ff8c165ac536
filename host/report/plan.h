// SPDX-License-Identifier: Apache-2.0
// The plan of a scene: what its steps launch and which memory it takes, before it runs.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha {

struct Amplification;   // host/report/amplification.h
struct DeviceEstimate;  // host/report/device_estimate.h

/// Particles, constraints, colours and batch sizes, passes of a step, bytes by owner, and whether Embree is used.
std::string plan(const Simulation& simulation);

/// The same as JSON, with snake_case names and the unit as suffix, and after the first step what that launched.
/// `estimate`: of a step on a machine, if one was named.
/// `amplifications`: of each body, where they were measured.
std::string plan_json(const Simulation& simulation, const DeviceEstimate* estimate = nullptr,
                      const std::vector<std::optional<Amplification>>* amplifications = nullptr);

/// The most memory that this process has held, with all that libraries hold, and what a checkpoint adds to it.
std::string list_process_memory(const Simulation& simulation);

/// What its first step launched, kernel by kernel; nothing before that step.
std::string list_launches(const Simulation& simulation);

}  // namespace malha
