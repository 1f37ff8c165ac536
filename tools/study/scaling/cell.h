// SPDX-License-Identifier: Apache-2.0
// One cell of the study "scaling": a method on a number of threads after the other, taking turns.
#pragma once
#include <optional>
#include <vector>

#include "tools/bench/counts.h"
#include "tools/study/cells.h"
#include "tools/study/cloth_methods.h"

namespace malha::study {

/// A simulation that takes part in the turns: N x N particles on so many threads.
struct ScalingRun {
  int threads, side;
};

/// 1, 2, 4 ... and the number of cores; 1 and 2 on a single core.
std::vector<int> scaling_threads(int cores = bench::cores());

/// {lines: [{threads, particles, step_s: [one a turn], least_step_s, passes_s: {name: seconds a step}, setup_s, hash,
/// patches, phases, must_move_bytes, triad_gb_per_s}], load_average}; or {left_out: why} where they do not fit in
/// memory together. `must_move_bytes`: what the largest pass has to read and write a step, if nothing stays in caches
/// between substeps.
Json scaling_cell(const ClothMethod& method, const std::vector<ScalingRun>& lines, const Cells& cells);

/// {threads, fork_join_us, fork_join_median_us, barrier_us}: an empty parallel region, and what one more launch in it
/// waits; the least of several windows, because other programs on the cores only add to it.
Json launch_costs(int threads, bool quick);

/// The share s of the work that more threads do not speed up: seconds(t) = seconds(1) (s + (1 - s) / t), by least
/// squares (Amdahl 1967). Of two lines or more, the first on one thread. None where no share from 0 to 1 is the best:
/// faster than threads alone explain, or slower than on one thread.
std::optional<double> serial_fraction(const std::vector<int>& threads, const std::vector<double>& seconds);

/// The busiest thread's patches over the mean, where a phase's patches are dealt out in equal numbers: 1 is even.
double imbalance(int patches, int phases, int threads);

}  // namespace malha::study
