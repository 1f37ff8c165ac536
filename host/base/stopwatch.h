// SPDX-License-Identifier: Apache-2.0
// Measurement of time.
#pragma once
#include <time.h>

#include <chrono>

namespace malha {

/// Seconds that work() takes.
template <class F>
double seconds(F&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// CPU time of work() on this thread, s: without waiting, and without other programs on its core.
template <class F>
double thread_seconds(F&& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

}  // namespace malha
