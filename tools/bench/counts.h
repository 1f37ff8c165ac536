// What a benchmark is asked for: the numbers and cases that it goes through.
#pragma once
#include <algorithm>
#include <string>
#include <thread>
#include <vector>

namespace malha::bench {

/// What all benchmarks take.
struct MeasuringOptions {
  std::vector<int> threads;  // empty: 1 and all cores
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

/// Those given, or 1 and all cores.
inline std::vector<int> thread_counts(const std::vector<int>& given) {
  return sorted(given.empty() ? std::vector{1, cores()} : given);
}

/// Of its cases.
template <class Case>
std::vector<std::string> names_of(const std::vector<Case>& cases) {
  std::vector<std::string> names;
  for (const Case& one : cases) names.emplace_back(one.name);
  return names;
}

}  // namespace malha::bench
