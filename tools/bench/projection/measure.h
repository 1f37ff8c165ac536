// SPDX-License-Identifier: Apache-2.0
// Times a case: all that run it take turns, so that what else the machine does hits them alike.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/counts.h"
#include "tools/bench/projection/row.h"

namespace malha::bench {

inline constexpr int kWarmUpSteps = 60;

/// How many lines of a case are malha's: schedules by numbers of threads. All stay in memory while they take turns.
std::size_t lines_of_malha(const std::vector<int>& threads);
/// Bytes a particle of such a line, and beside them while one is set up. As the peaks (ru_maxrss) with --n 1000 say,
/// --threads 1 and 1,2,3, and with --case irregular --n 1000000, rounded up.
inline constexpr double kLineBytes = 200, kSetUpBytes = 400;

/// Why Bullet gets no row of this case; empty: it gets one.
std::string bullet_left_out(const Case& which);

/// The rows of malha (schedules 10x1 and 1x10, and 10x1 with levels where "auto" has any, on all the thread counts) and
/// of Bullet (1x10, one thread). A repeat is one step at least. `doing` hears in a few words what comes next and which
/// part of the whole case is done. Takes the case's mesh file away once it is read. Throws Diverged.
std::vector<Row> measure(Case which, const MeasuringOptions& timing,
                         const std::function<void(const std::string&, double part)>& doing);

/// Fills the row's working set, triad and floors. Every substep must read and write its particles once (position and
/// inverse mass, velocity), every further iteration their positions, and where no pattern gives them, each projection
/// reads its rest length and two 16-bit indices; it takes one square root and one division.
/// `root_ns`: of those two on one thread of the host. More threads than `cores` are no faster.
void set_floor(Row& row, double triad_gb_per_s, double root_ns, int cores);
double working_set_bytes(const Row& row);

}  // namespace malha::bench
