// SPDX-License-Identifier: Apache-2.0
// Times the filter products at one size: all variants on the same number of threads are measured in turns.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/counts.h"
#include "tools/bench/filter/row.h"

namespace malha::bench {

struct FilterTiming : MeasuringOptions {
  bool dense = true, sparse = true;
};

struct FilterRows {
  std::vector<FilterRow> rows;
  std::vector<std::string> left_out;  // "variant: reason"
};

/// Measures dense filters (with all storages, and OpenBLAS) and sparse ones on each number of threads. A repeat is at
/// least one product. `show_progress` gets a short description of the next measurement and the finished part of this
/// size, 0 to 1.
FilterRows measure_filters(int side, const FilterTiming& timing,
                           const std::function<void(const std::string&, double part)>& show_progress);

}  // namespace malha::bench
