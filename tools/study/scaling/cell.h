// SPDX-License-Identifier: Apache-2.0
// A cell of the study "scaling": a method on several numbers of threads, measured in turns.
#pragma once
#include <optional>
#include <vector>

#include "tools/bench/counts.h"
#include "tools/study/cells.h"
#include "tools/study/cloth_methods.h"

namespace malha::study {

/// A simulation that is measured in turns with others: side x side particles on `threads` threads.
struct ScalingRun {
  int threads, side;
};

/// Numbers of threads: 1, 2, 4 ... and the number of cores; 1 and 2 on a single core.
std::vector<int> scaling_threads(int cores = bench::cores());

/// {lines: [{threads, particles, step_s: [one a turn], least_step_s, passes_s: {name: seconds a step}, setup_s, hash,
/// patches, patch_colors, must_move_bytes, triad_gb_per_s}], load_average}; or {left_out: reason} if the simulations do
/// not fit into memory together. `must_move_bytes`: bytes per step that the largest pass has to read and write if
/// nothing stays in caches between substeps. `patch_colors`: colours of patches.
Json scaling_cell(const ClothMethod& method, const std::vector<ScalingRun>& lines, const Cells& cells);

/// {threads, fork_join_us, fork_join_median_us, barrier_us}: times of an empty parallel region, and of a barrier for
/// one more launch in it. Minima of several windows, because other programs on the cores only add to them.
Json launch_costs(int threads, bool quick);

/// The serial fraction s of the work: seconds(t) = seconds(1) (s + (1 - s) / t), by least squares (Amdahl 1967), from
/// two or more numbers of threads, the first of which is 1. Empty if the best s is not in [0, 1]: speed-ups are larger
/// than the number of threads, or more threads are slower than one.
std::optional<double> serial_fraction(const std::vector<int>& threads, const std::vector<double>& seconds);

/// Number of patches of the busiest thread over the mean, if the patches of a colour (`colours`: their number) are
/// distributed in equal numbers; 1: balanced.
double imbalance(int patches, int colours, int threads);

}  // namespace malha::study
