// What of self-collision a later substep depends on.
#pragma once
#include <array>
#include <utility>
#include <vector>

namespace malha {

template <class R>
struct SelfMemory {
  std::vector<std::array<R, 3>> x0;    // positions without crossings, m
  std::vector<std::array<R, 4>> from;  // of the last search: where it started, and how far beyond the ways it looked, m
  std::vector<std::array<R, 3>> way;
  std::vector<double> frame;  // whether there was one that still holds; how far the frame has moved since and moves, m
};

/// With these positions, and no search that holds.
template <class R>
SelfMemory<R> unsearched(std::vector<std::array<R, 3>> x0) {
  const std::size_t n = x0.size();
  return {std::move(x0), std::vector<std::array<R, 4>>(n), std::vector<std::array<R, 3>>(n), std::vector<double>(7, 0)};
}

}  // namespace malha
