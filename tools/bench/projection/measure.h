// SPDX-License-Identifier: Apache-2.0
// Measures a case: all libraries, schedules and numbers of threads run in turns, so that other load of the machine
// affects them alike.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/counts.h"
#include "tools/bench/projection/row.h"

namespace malha::bench {

inline constexpr int kWarmUpSteps = 60;

/// The number of malha's rows of a case: schedules times numbers of threads. Their simulations are in memory together.
std::size_t lines_of_malha(const std::vector<int>& threads);
/// Bytes per particle of such a simulation, and additional ones while one is set up. Rounded up from the peaks
/// (ru_maxrss) with --n 1000, --threads 1 and 1,2,3, and with --case irregular --n 1000000.
inline constexpr double kLineBytes = 200, kSetUpBytes = 400;

/// The reason why Bullet has no row of this case; empty if it has one.
std::string bullet_left_out(const Case& which);

/// The rows of malha (schedules 10x1 and 1x10, and 10x1 with levels if "auto" makes any, on all numbers of threads) and
/// of Bullet (1x10, one thread). A repeat is at least one step. `show_progress` gets a short description of the next
/// measurement and the finished part of the case, 0 to 1. Removes the case's mesh file after reading it. Throws
/// Diverged.
std::vector<Row> measure(Case which, const MeasuringOptions& timing,
                         const std::function<void(const std::string&, double part)>& show_progress);

/// Sets the row's working set, triad and floors (lower bounds of the time). Every substep must read and write its
/// particles once (position and inverse mass, velocity), and every further iteration their positions. Each projection
/// reads its rest length and two 16-bit indices, unless a grid's pattern yields them, and takes one square root and one
/// division. `root_ns`: time of those two on one thread of the host. More threads than `cores` are no faster.
void set_floor(Row& row, double triad_gb_per_s, double root_ns, int cores);
double working_set_bytes(const Row& row);

}  // namespace malha::bench
