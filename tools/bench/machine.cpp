#include "tools/bench/machine.h"

#include <algorithm>
#include <barrier>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "host/base/stopwatch.h"
#include "kernels/pack.h"

namespace malha::bench {

namespace {

using Lanes = Lane<float>;

/// The compiler may neither drop nor merge passes over memory across this.
void keep_memory() { asm volatile("" ::: "memory"); }

/// One thread's part of the three arrays, in one piece of memory.
class Triad {
 public:
  explicit Triad(std::size_t bytes)
      // The odd gaps keep the three arrays off each other's cache sets.
      : n_(std::max<std::size_t>(1, bytes / 3 / sizeof(Lanes))), memory_(3 * n_ + 10, Lanes(1.0f)) {}

  void pass() {
    Lanes* __restrict a = memory_.data();
    const Lanes *b = a + n_ + 5, *c = b + n_ + 5;
    const Lanes s(0.5f);
    for (std::size_t i = 0; i < n_; ++i) a[i] = b[i] + s * c[i];
    keep_memory();
  }
  double bytes() const { return 3.0 * static_cast<double>(n_ * sizeof(Lanes)); }

 private:
  std::size_t n_;
  std::vector<Lanes> memory_;
};

/// x = 2 / sqrt(x), again and again.
template <class Isa>
struct Chains {
  static constexpr int chains = 8;  // enough that latency does not count, few enough for 16 registers
  static constexpr int turns = 20000;
  volatile float* wanted;
  int round;
  KERNEL void operator()(int) const {
    using S = Lane<float, Isa>;
    S x[chains];
    for (int k = 0; k < chains; ++k) x[k] = S(1.5f + float(k + round));
    for (int turn = 0; turn < turns; ++turn)
      for (int k = 0; k < chains; ++k) x[k] = S(2.0f) / root(x[k]);
    for (int k = 0; k < chains; ++k) *wanted = *wanted + lane(x[k], 0);
  }
};

}  // namespace

double triad_gb_per_s(std::size_t bytes, int threads) {
  constexpr double round_bytes = 1e8;  // some milliseconds: the threads' meeting costs nothing beside them
  constexpr int rounds = 15;
  const int passes = std::max(1, static_cast<int>(round_bytes / static_cast<double>(bytes)));
  std::barrier meet(threads);
  double best = 0;
  const auto work = [&](bool first) {
    Triad part(bytes / static_cast<std::size_t>(threads));
    part.pass();
    for (int round = 0; round < rounds; ++round) {
      meet.arrive_and_wait();
      const double time = seconds([&] {
        for (int k = 0; k < passes; ++k) part.pass();
        meet.arrive_and_wait();
      });
      if (first) best = std::max(best, part.bytes() * threads * passes / time / 1e9);
    }
  };
  std::vector<std::jthread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work, false);
  work(true);
  return best;
}

double free_memory_bytes() {
  std::ifstream info("/proc/meminfo");
  double kib = 0;
  for (std::string word; info >> word;)
    if (word == "MemAvailable:" && info >> kib) return kib * 1024;
  return 0;
}

double root_and_quotient_ns() {
  constexpr int rounds = 15;
  double best = 1e9;
  volatile float wanted = 0;  // or the compiler would leave the work out
  for_each_isa([&]<class Isa>(Isa isa) {
    if (Isa::value != widest_instructions()) return;
    using Work = Chains<Isa>;
    for (int round = 0; round < rounds; ++round) {
      const double time = seconds([&] { run(isa, Work{&wanted, round}, 0, 1); });
      best = std::min(best, time * 1e9 / (double(Work::turns) * Work::chains * kLanes<float, Isa>));
    }
  });
  return best;
}

}  // namespace malha::bench
