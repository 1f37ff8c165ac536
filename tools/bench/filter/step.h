// SPDX-License-Identifier: Apache-2.0
// How many particles run in real time by Desbrun's method.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "malha/scene.h"
#include "tools/bench/filter/row.h"
#include "tools/bench/runs_on.h"

namespace malha::bench {

inline constexpr double kFrameMs = 16.6;  // of a step at 60 Hz

struct StepSearch {
  RunsOn on;
  FilterKind filter = FilterKind::Sparse;
  int threads = 1;
  int cap = 1000;      // the largest side to try
  double seconds = 1;  // of stepping at each size, at least kSteps
};

/// The largest grid, to 2 % of its side, whose median step (all of Simulation::step) takes at most kFrameMs, with its
/// row: `seconds` has every step. None: not even the smallest.
std::optional<FilterRow> real_time(const StepSearch& search, const std::function<void(const std::string&)>& doing);

/// The search itself: the largest side in [least, cap] with ms(side) <= kFrameMs, about; 0: none. `exponent`: with
/// which power of the side ms grows, a guess.
int largest_side(int least, int guess, int cap, double exponent, const std::function<double(int side)>& ms);

}  // namespace malha::bench
