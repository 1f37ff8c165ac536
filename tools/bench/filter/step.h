// SPDX-License-Identifier: Apache-2.0
// Search for the largest cloth that Desbrun's method runs in real time.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "malha/scene.h"
#include "tools/bench/filter/row.h"
#include "tools/bench/runs_on.h"

namespace malha::bench {

inline constexpr double kFrameMs = 16.6;  // the longest step at 60 Hz

struct StepSearch {
  RunsOn on;
  FilterKind filter = FilterKind::Sparse;
  int threads = 1;
  int cap = 1000;      // the largest side to try
  double seconds = 1;  // of steps at each size, at least kSteps of them
};

/// The row of the largest grid, to 2 % of its side, whose median step (all of Simulation::step) takes at most kFrameMs.
/// Its `seconds` are those of every step. Empty if the smallest grid takes longer.
std::optional<FilterRow> find_real_time_limit(const StepSearch& search,
                                              const std::function<void(const std::string&)>& show_progress);

/// The search itself: approximately the largest side in [least, cap] with ms(side) <= kFrameMs; 0: none. `exponent`:
/// the estimated power of the side with which ms grows.
int largest_side(int least, int guess, int cap, double exponent, const std::function<double(int side)>& ms);

}  // namespace malha::bench
