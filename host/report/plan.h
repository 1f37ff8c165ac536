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

/// Returns the plan as JSON, with snake_case names and units as suffixes: particles, constraints, colours and batch
/// sizes, passes of a step, memory by owner, and after the first step its launches by kernel.
/// `estimate`: of a step on a machine, if one was named. `amplifications`: by body, if they were measured.
std::string plan_json(const Simulation& simulation, const DeviceEstimate* estimate = nullptr,
                      const std::vector<std::optional<Amplification>>* amplifications = nullptr);

/// Returns the JSON as text, with the same names, units after numbers, and without entries that are 0 or empty.
std::string plan(const Simulation& simulation, const DeviceEstimate* estimate = nullptr,
                 const std::vector<std::optional<Amplification>>* amplifications = nullptr);

}  // namespace malha
