// SPDX-License-Identifier: Apache-2.0
// How fast threads can read memory, and read and write it.
#pragma once
#include <cstddef>
#include <memory>
#include <vector>

namespace malha::bench {

/// Arrays of float, each thread's its own and first touched by it.
class Streams {
 public:
  /// `bytes`: the most that is moved at a time.
  Streams(std::size_t bytes, int threads);

  /// Seconds to read `bytes` once: eight arrays a thread side by side, added up, because one alone leaves prefetchers
  /// idle. Means over at least `enough` seconds, in which no thread waits for another but at the end.
  double read(std::size_t bytes, double enough = 0) const;
  /// Seconds of one STREAM triad a = b + s c (McCalpin 1995) over arrays of `bytes` together.
  double triad(std::size_t bytes, double enough = 0) const;

 private:
  template <class Kernel>
  double timed(std::size_t bytes, double enough, Kernel kernel) const;

  struct Release {
    void operator()(float* data) const;
  };
  int threads_;
  std::vector<std::unique_ptr<float, Release>> memory_;
  std::vector<float*> parts_;  // of each thread
  mutable std::vector<float> sums_;
};

}  // namespace malha::bench
