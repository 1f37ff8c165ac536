// SPDX-License-Identifier: Apache-2.0
// Options that all benchmarks share.
#pragma once
#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "tools/bench/runs_on.h"

namespace malha::bench {

/// Options of every benchmark.
struct MeasuringOptions {
  RunsOn on;
  std::vector<int> threads;  // of the host; empty: 1 and all cores, or all cores alone beside a device
  int repeats = 5;
  double seconds = 1;  // of each repeat
  std::string json;    // another file for the rows; empty: none
  std::string out;     // folder; empty: out/bench_NAME
};

/// The numbers in ascending order, without duplicates.
inline std::vector<int> sorted(std::vector<int> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

inline int cores() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

inline std::vector<int> thread_counts(const MeasuringOptions& options) {
  if (!options.threads.empty()) return sorted(options.threads);
  return options.on.is_device() ? std::vector{cores()} : sorted({1, cores()});
}

template <class Case>
std::vector<std::string> case_names(const std::vector<Case>& cases) {
  std::vector<std::string> names;
  for (const Case& one : cases) names.emplace_back(one.name);
  return names;
}

}  // namespace malha::bench
