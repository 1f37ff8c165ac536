// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/stream.h"

#include <algorithm>

#include "host/base/array.h"
#include "host/base/stopwatch.h"
#include "kernels/parallel/compute.h"
#include "kernels/simd/pack.h"

namespace malha::bench {

namespace {

constexpr int kLine = 16;  // floats in a cache line and in the widest pack
constexpr int kArrays = 8;
constexpr int kGap = 5 * kLine;  // an odd number of lines keeps the arrays in different cache sets

/// Keeps the compiler from removing or merging passes over memory.
KERNEL void keep_memory() { asm volatile("" ::: "memory"); }

struct Fill {
  float* const* parts;
  std::size_t floats;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for (std::size_t i = 0; i < floats; ++i) parts[group.index][i] = 1;
  }
};

/// Each thread's memory as several arrays of `n` floats.
struct Part {
  float* const* parts;
  std::size_t n;
  KERNEL float* array(int thread, int k) const { return parts[thread] + std::size_t(k) * (n + kGap); }
};

struct Read {
  static constexpr int arrays = kArrays;
  Part part;
  float* sums;  // results, so that the compiler removes nothing
  int passes = 1;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<float, typename Group::Isa>;
    const float* at[arrays];
    for (int k = 0; k < arrays; ++k) at[k] = part.array(group.index, k);
    for (int pass = 0; pass < passes; ++pass) {
      S sum[arrays];
      for (int k = 0; k < arrays; ++k) sum[k] = S(0.0f);
      for (std::size_t i = 0; i < part.n; i += S::lanes)
        for (int k = 0; k < arrays; ++k) {
          S numbers;
          load(at[k] + i, numbers);
          sum[k] = sum[k] + numbers;
        }
      for (int k = 1; k < arrays; ++k) sum[0] = sum[0] + sum[k];
      store(sum[0], sums + kLine * group.index);
      keep_memory();
    }
  }
};

struct Triad {
  static constexpr int arrays = 3;
  Part part;
  int passes = 1;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<float, typename Group::Isa>;
    float* a = part.array(group.index, 0);
    const float *b = part.array(group.index, 1), *c = part.array(group.index, 2);
    const S s(0.5f);
    for (int pass = 0; pass < passes; ++pass) {
      for (std::size_t i = 0; i < part.n; i += S::lanes) {
        S x, y;
        load(b + i, x), load(c + i, y);
        store(x + s * y, a + i);
      }
      keep_memory();
    }
  }
};

/// Length of each array of a thread, in floats; whole cache lines.
std::size_t floats_of_array(std::size_t bytes, int threads, int arrays) {
  return std::max<std::size_t>(1, bytes / (sizeof(float) * kLine * threads * arrays)) * kLine;
}

template <class Kernel>
void run_on_all_threads(int threads, const Kernel& kernel) {
  const OpenMP executor{threads};
  parallel_region(executor, threads, [&](const auto& team) { parallel_groups(team, 0, threads, {}, kernel); });
}

}  // namespace

void Streams::Release::operator()(float* data) const { Memory<OpenMP>::release(data, 0, nullptr); }

Streams::Streams(std::size_t bytes, int threads) : threads_(threads), sums_(std::size_t(kLine) * threads) {
  const std::size_t floats = std::max(kArrays * (floats_of_array(bytes, threads, kArrays) + kGap),
                                      Triad::arrays * (floats_of_array(bytes, threads, Triad::arrays) + kGap));
  for (int t = 0; t < threads; ++t) {
    memory_.emplace_back(static_cast<float*>(Memory<OpenMP>::allocate(floats * sizeof(float), nullptr)));
    parts_.push_back(memory_.back().get());
  }
  run_on_all_threads(threads, Fill{parts_.data(), floats});
}

template <class Kernel>
double Streams::time_kernel(std::size_t bytes, double min_seconds, Kernel kernel) const {
  constexpr double batch = 1e8;  // bytes; takes some milliseconds, so that fork and join do not count
  kernel.part = {parts_.data(), floats_of_array(bytes, threads_, Kernel::arrays)};
  const double moved = double(kernel.part.n) * sizeof(float) * Kernel::arrays * threads_;
  kernel.passes = std::max(1, static_cast<int>(batch / moved));
  double time = 0, passes = 0;
  do {
    time += seconds([&] { run_on_all_threads(threads_, kernel); });
    passes += kernel.passes;
  } while (time < min_seconds);
  return time / passes * double(bytes) / moved;
}

double Streams::read(std::size_t bytes, double min_seconds) const {
  return time_kernel(bytes, min_seconds, Read{{}, sums_.data()});
}

double Streams::triad(std::size_t bytes, double min_seconds) const {
  return time_kernel(bytes, min_seconds, Triad{{}});
}

}  // namespace malha::bench
