// An executor that shows without a device what would go wrong on one: every group is worked on by the threads of a
// block, each for itself up to where all wait for each other, and after each wait in another order. What depends on the
// order, what each thread repeats, and a wait that not all come to, show in the results or end the launch.
#pragma once
#include <algorithm>
#include <boost/context/fiber.hpp>
#include <boost/context/pooled_fixedsize_stack.hpp>
#include <cstring>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "kernels/compute.h"

namespace malha {

/// `block`: threads of each. Kernels that do not share their work (kShared) run on one thread a group.
struct Blocks {
  int block = 32;                                     // threads
  unsigned seed = 1;                                  // of the orders
  Instructions instructions = widest_instructions();  // of what the host computes
};

/// The threads of a block, as fibers.
class Turns {
 public:
  struct Thread {
    Turns* all;
    int number;
    int rank() const { return number; }
    int count() const { return static_cast<int>(all->lanes_.size()); }
    void wait(int items) const { all->wait(number, items); }
  };

  Turns(int threads, unsigned seed) : lanes_(threads), order_(threads), random_(seed) {
    std::iota(order_.begin(), order_.end(), 0);
  }

  /// Runs work(Thread) on each.
  template <class Work>
  void run(const Work& work) {
    for (int rank : order_)
      lanes_[rank].self = Fiber(std::allocator_arg, stacks(), [&, rank](Fiber&& scheduler) {
        lanes_[rank].scheduler = std::move(scheduler);
        work(Thread{this, rank});
        return std::move(lanes_[rank].scheduler);
      });
    while (lanes_[0].self) {
      std::shuffle(order_.begin(), order_.end(), random_);
      for (const int rank : order_) lanes_[rank].self = std::move(lanes_[rank].self).resume();
      for (const Lane& lane : lanes_)
        if (bool(lane.self) != bool(lanes_[0].self) || lane.items != lanes_[0].items)
          throw std::logic_error("a block's threads part: some wait where others do not");
    }
  }

 private:
  using Fiber = boost::context::fiber;
  struct Lane {
    Fiber self, scheduler;
    int items = -1;  // what it waits after
  };
  static boost::context::pooled_fixedsize_stack& stacks() {
    static boost::context::pooled_fixedsize_stack pool(256 * 1024);
    return pool;
  }
  void wait(int rank, int items) {
    lanes_[rank].items = items;
    lanes_[rank].scheduler = std::move(lanes_[rank].scheduler).resume();
  }

  std::vector<Lane> lanes_;
  std::vector<int> order_;
  std::mt19937 random_;
};

/// Calls work for 0 .. n - 1 in an order that is not theirs.
template <class Work>
void shuffled(int n, unsigned seed, const Work& work) {
  constexpr int kStep = 7919;  // a prime: of n that it does not divide it reaches all
  const long long step = n % kStep == 0 ? 1 : kStep;
  for (int k = 0; k < n; ++k) work(static_cast<int>((k * step + seed) % n));
}

inline bool leads(const Blocks&) { return true; }
inline Blocks narrow(const Blocks& executor) { return executor; }

template <class Work>
void parallel_region(const Blocks& executor, int /*width*/, const Work& work) {
  work(executor);
}

template <class Kernel>
void parallel_for(const Blocks& executor, int n, const Kernel& kernel, int /*grain*/ = kParticleGrain) {
  note_launch(kernel, n);
  shuffled(n, executor.seed, kernel);
}

/// Fast memory is the group's own, and full of what is no number.
template <class Kernel>
void parallel_groups(const Blocks& executor, int begin, int end, const FastMemory& memory, const Kernel& kernel) {
  note_launch(kernel, end - begin);
  std::vector<double> fast(memory.bytes / sizeof(double) + 8);
  shuffled(end - begin, executor.seed, [&](int k) {
    std::memset(fast.data(), 0xff, fast.size() * sizeof(double));
    void* aligned = reinterpret_cast<void*>((reinterpret_cast<std::uintptr_t>(fast.data()) + 63) / 64 * 64);
    if constexpr (kShared<Kernel>)
      Turns(executor.block, executor.seed + static_cast<unsigned>(begin + k)).run([&](const Turns::Thread& thread) {
        kernel(Block<Turns::Thread>{begin + k, aligned, thread});
      });
    else
      kernel(Group<OneLane>{begin + k, -1, aligned});
  });
}

template <class Kernel>
void parallel_dealt(const Blocks& executor, int groups, const Kernel& kernel, const FastMemory& memory = {}) {
  parallel_groups(executor, 0, groups, memory, kernel);
}

}  // namespace malha
