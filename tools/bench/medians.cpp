// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/medians.h"

#include <algorithm>
#include <chrono>

namespace malha::bench {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double mean_seconds(const std::function<void()>& work, double min_seconds) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  std::chrono::duration<double> elapsed{};
  int times = 0;
  do {
    work();
    ++times;
    elapsed = Clock::now() - start;
  } while (elapsed.count() < min_seconds);
  return elapsed.count() / times;
}

double median_ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t turn = 0; turn < a.size(); ++turn) ratios.push_back(a[turn] / b[turn]);
  return median(ratios);
}

}  // namespace malha::bench
