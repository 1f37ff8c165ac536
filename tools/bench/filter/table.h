// SPDX-License-Identifier: Apache-2.0
// The results of malha bench filter as a person reads them.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/filter/row.h"

namespace malha::bench {

/// The products at one size under their heading. `rows` are all of one size.
std::string filter_table(const std::vector<FilterRow>& rows, const std::vector<std::string>& left_out);

/// What runs in real time; `rows` are steps.
std::string step_table(const std::vector<FilterRow>& rows);

/// From which size on the sparse filter is the faster one, on each number of threads, in float.
std::string crossover(const std::vector<FilterRow>& rows);

/// What malha promises of its filters beside what was measured. `cache_bytes`: what exceeds them is read from memory;
/// 0: unknown.
std::string bars(const std::vector<FilterRow>& rows, double cache_bytes);

}  // namespace malha::bench
