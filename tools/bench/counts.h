// SPDX-License-Identifier: Apache-2.0
// What a benchmark is asked for: the numbers and cases that it goes through.
#pragma once
#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "tools/bench/runs_on.h"

namespace malha::bench {

/// What all benchmarks take.
struct MeasuringOptions {
  RunsOn on;
  std::vector<int> threads;  // empty: 1 and all cores; of a device all cores, for what the host does
  int repeats = 5;
  double seconds = 1;  // of each repeat
  std::string json;    // a further file for the rows; empty: none
  std::string out;     // folder; empty: out/bench_NAME
};

/// Ascending, each once.
inline std::vector<int> sorted(std::vector<int> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

inline int cores() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

inline std::vector<int> thread_counts(const MeasuringOptions& options) {
  if (!options.threads.empty()) return sorted(options.threads);
  return options.on.device() ? std::vector{cores()} : sorted({1, cores()});
}

/// Of its cases.
template <class Case>
std::vector<std::string> names_of(const std::vector<Case>& cases) {
  std::vector<std::string> names;
  for (const Case& one : cases) names.emplace_back(one.name);
  return names;
}

}  // namespace malha::bench
