// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/machine.h"

#include <algorithm>
#include <fstream>
#include <string>

#include "host/base/stopwatch.h"
#include "kernels/simd/pack.h"
#include "tools/bench/pinned.h"
#include "tools/bench/stream.h"

namespace malha::bench {

namespace {

/// The highest bandwidth of several rounds.
double best_gb_per_s(std::size_t bytes, int threads, double (Streams::*pass)(std::size_t, double) const) {
  const Pinned pinned(threads);
  const Streams streams(bytes, threads);
  double best = 0;
  for (int round = 0; round < 15; ++round) best = std::max(best, double(bytes) / (streams.*pass)(bytes, 0) / 1e9);
  return best;
}

/// Independent chains of x = 2 / sqrt(x).
template <class Isa>
struct Chains {
  static constexpr int chains = 8;  // enough that latency does not count, few enough for 16 registers
  static constexpr int turns = 20000;
  volatile float* sink;
  int round;
  KERNEL void operator()(int) const {
    using S = Lane<float, Isa>;
    S x[chains];
    for (int k = 0; k < chains; ++k) x[k] = S(1.5f + float(k + round));
    for (int turn = 0; turn < turns; ++turn)
      for (int k = 0; k < chains; ++k) x[k] = S(2.0f) / sqrt(x[k]);
    for (int k = 0; k < chains; ++k) *sink = *sink + lane(x[k], 0);
  }
};

}  // namespace

double triad_gb_per_s(std::size_t bytes, int threads) { return best_gb_per_s(bytes, threads, &Streams::triad); }

double read_gb_per_s(std::size_t bytes, int threads) { return best_gb_per_s(bytes, threads, &Streams::read); }

double cache_bytes() {
  double largest = 0;
  for (int index = 0; index < 8; ++index) {
    // sysconf would return the sum over all caches of the processor.
    std::ifstream file("/sys/devices/system/cpu/cpu0/cache/index" + std::to_string(index) + "/size");
    double size = 0;
    char unit = 'K';
    if (file >> size >> unit) largest = std::max(largest, size * (unit == 'M' ? 1 << 20 : 1 << 10));
  }
  return largest;
}

double root_and_quotient_ns() {
  constexpr int rounds = 15;
  double best = 1e9;
  volatile float sink = 0;  // keeps the compiler from removing the work
  for_each_isa([&]<class Isa>(Isa isa) {
    if (Isa::value != widest_instructions()) return;
    using Work = Chains<Isa>;
    for (int round = 0; round < rounds; ++round) {
      const double time = seconds([&] { run(isa, Work{&sink, round}, 0, 1); });
      best = std::min(best, time * 1e9 / (double(Work::turns) * Work::chains * kLanes<float, Isa>));
    }
  });
  return best;
}

}  // namespace malha::bench
