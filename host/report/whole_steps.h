// SPDX-License-Identifier: Apache-2.0
// Conversion of simulated times to whole steps.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "malha/text.h"

namespace malha {

/// Returns the number of steps of `dt` nearest to this time, at least one.
inline std::int64_t whole_steps(double seconds, double dt) {
  return std::max<std::int64_t>(1, std::llround(seconds / dt));
}

/// Returns the message where rounding to whole steps changes a time: "NAME, 0.5 s, is 1.66667 steps of 0.3 s: 2 are
/// run, to 0.6 s". It is empty where the times differ by less than 1 % of a step, or in the sixth digit, because a step
/// of 1/60 s is often written with six.
inline std::string rounding_of(const std::string& name, double seconds, double dt) {
  const auto steps = static_cast<double>(whole_steps(seconds, dt));
  if (std::abs(steps * dt - seconds) < std::max(0.01 * dt, 1e-5 * seconds)) return "";
  return name + ", " + shown(seconds) + " s, is " + shown(seconds / dt) + " steps of " + shown(dt) +
         " s: " + (steps == 1 ? "1 is" : shown(steps) + " are") + " run, to " + shown(steps * dt) + " s";
}

}  // namespace malha
