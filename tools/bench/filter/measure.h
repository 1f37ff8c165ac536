// SPDX-License-Identifier: Apache-2.0
// Times the products of filters at one size: all that run on as many threads take turns.
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
  std::vector<std::string> left_out;  // "what: why"
};

/// Dense (with its storages, and OpenBLAS) and sparse, on each number of threads. A repeat is one product at least.
/// `doing` hears in a few words what comes next and which part of the whole size is done.
FilterRows measure_filters(int side, const FilterTiming& timing,
                           const std::function<void(const std::string&, double part)>& doing);

}  // namespace malha::bench
