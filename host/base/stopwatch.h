// How long a piece of work takes.
#pragma once
#include <chrono>

namespace malha {

/// Seconds that work() takes.
template <class F>
double seconds(F&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace malha
