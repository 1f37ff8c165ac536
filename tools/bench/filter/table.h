// SPDX-License-Identifier: Apache-2.0
// Printed tables of malha bench filter.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/filter/row.h"

namespace malha::bench {

/// The table of products at one size. All `rows` are of that size.
std::string filter_table(const std::vector<FilterRow>& rows, const std::vector<std::string>& left_out);

/// The table of sizes that run in real time; `rows` are steps.
std::string step_table(const std::vector<FilterRow>& rows);

/// Lines that say from which size on the sparse filter is faster, on each number of threads, in float.
std::string crossover(const std::vector<FilterRow>& rows);

/// The promised speed of malha's filters beside the measured one. `cache_bytes`: larger filters are read from memory;
/// 0: unknown.
std::string promise_lines(const std::vector<FilterRow>& rows, double cache_bytes);

}  // namespace malha::bench
