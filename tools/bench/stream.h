// SPDX-License-Identifier: Apache-2.0
// Memory bandwidth of threads: reading, and the STREAM triad.
#pragma once
#include <cstddef>
#include <memory>
#include <vector>

namespace malha::bench {

/// Arrays of float for each thread, which it touches first, so that they lie in its memory.
class Streams {
 public:
  /// `bytes`: the largest size that read() and triad() are called with.
  Streams(std::size_t bytes, int threads);

  /// Seconds to read `bytes` once. Each thread sums up eight arrays side by side, because one alone leaves prefetchers
  /// idle. A mean over at least `min_seconds`; threads wait for each other only at the end of a batch.
  double read(std::size_t bytes, double min_seconds = 0) const;
  /// Seconds of one STREAM triad a = b + s c (McCalpin 1995) over three arrays, `bytes` together.
  double triad(std::size_t bytes, double min_seconds = 0) const;

 private:
  template <class Kernel>
  double time_kernel(std::size_t bytes, double min_seconds, Kernel kernel) const;

  struct Release {
    void operator()(float* data) const;
  };
  int threads_;
  std::vector<std::unique_ptr<float, Release>> memory_;
  std::vector<float*> parts_;  // the memory of each thread
  mutable std::vector<float> sums_;
};

}  // namespace malha::bench
