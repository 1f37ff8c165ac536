// SPDX-License-Identifier: Apache-2.0
// Steps that are looked at in parts.
#pragma once
#include <functional>

namespace malha {

/// Called after each substep of a step with its number, from 1, and the time that it has led to, s. positions() and
/// velocities() are then those of the substep. Nothing may be changed.
using SubstepCallback = std::function<void(int substep, double time)>;

}  // namespace malha
