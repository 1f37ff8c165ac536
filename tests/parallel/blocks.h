// SPDX-License-Identifier: Apache-2.0
// An executor that emulates a device's blocks of threads on the host: the threads of a block run one after the other up
// to the next barrier, in another order after each barrier. Results that depend on the order, code that every thread
// repeats, and barriers that not all threads reach, show as wrong bits or end the launch.
#pragma once
#include <sys/mman.h>

#include <algorithm>
#include <boost/context/fiber.hpp>
#include <boost/context/pooled_fixedsize_stack.hpp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/base/array.h"
#include "host/base/launch_graph.h"
#include "host/base/scoped_value.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// `block`: number of threads a block, or as many as a kernel can use. Kernels that do not share their work (kShared)
/// run on one thread a group.
struct Blocks {
  int block = 32;                                     // threads
  unsigned seed = 1;                                  // of the orders of threads
  Instructions instructions = widest_instructions();  // for what the host computes
};

/// While there is such a list, launches are appended to it and do not run.
inline std::vector<std::function<void()>>* kept_launches = nullptr;

/// Emulated device memory: only launches and copies may access it. Any other access by the host ends the program.
class EmulatedMemory {
 public:
  static EmulatedMemory& the() {
    static EmulatedMemory memory;
    return memory;
  }
  void* allocate(std::size_t bytes) {
    ++arrays_;
    return add(bytes);
  }
  /// All memory is released at once, with the last array.
  void release() {
    if (kept_launches) {
      std::fputs("an array is released that launches may use which are being recorded\n", stderr);
      std::abort();
    }
    if (--arrays_ > 0) return;
    protect(PROT_NONE), is_open_ = false, closings_ = 0;
    madvise(base_, used_, MADV_DONTNEED);
    used_ = 0, scratch_ = nullptr, scratch_bytes_ = 0;
  }
  /// Scratch memory, which the next launches may use again.
  void* scratch(std::size_t bytes) {
    if (bytes > scratch_bytes_) scratch_ = add(bytes), scratch_bytes_ = bytes;
    return scratch_;
  }
  bool has(std::uintptr_t address) const { return address - reinterpret_cast<std::uintptr_t>(base_) <= kMost; }
  /// The memory is accessible while an object of this type exists.
  struct Open {
    Open() { the().open(); }
    ~Open() { the().close(); }
    Open(const Open&) = delete;
    Open& operator=(const Open&) = delete;
  };

 private:
  EmulatedMemory() {
    void* const all = mmap(nullptr, kMost, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (all == MAP_FAILED) throw std::bad_alloc();
    base_ = static_cast<char*>(all);
  }
  void* add(std::size_t bytes) {
    const std::size_t begin = used_, size = (bytes + 63) / 64 * 64;
    if (size > kMost - begin) throw std::bad_alloc();
    used_ += size;
    if (is_open_) protect(PROT_READ | PROT_WRITE);
    return base_ + begin;
  }
  void open() {
    if (opened_++ > 0 || is_open_) return;
    protect(PROT_READ | PROT_WRITE), is_open_ = true;
  }
  /// In long runs memory is protected only sometimes, because that takes longer than most launches, and an error in one
  /// substep occurs in others too.
  void close() {
    constexpr unsigned kAlways = 1024, kSpread = 2654435761u;
    if (--opened_ > 0 || (++closings_ > kAlways && closings_ * kSpread >> 27 != 0)) return;
    protect(PROT_NONE), is_open_ = false;
  }
  void protect(int how) const {
    if (used_ > 0) mprotect(base_, (used_ + 4095) / 4096 * 4096, how);
  }

  static constexpr std::size_t kMost = std::size_t{16} << 30;  // bytes: addresses, not memory
  char* base_;
  std::size_t used_ = 0;
  void* scratch_ = nullptr;
  std::size_t scratch_bytes_ = 0;
  int arrays_ = 0, opened_ = 0;
  unsigned closings_ = 0;
  bool is_open_ = false;
};

/// True while recorded launches are replayed.
inline bool replaying = false;

/// Waits for the launches, which is an error while they are recorded.
inline void synchronize(const Blocks& /*executor*/) {
  if (kept_launches) throw std::logic_error("the host waits for launches that are being recorded");
}

template <>
struct Memory<Blocks> {
  static void* allocate(std::size_t bytes, std::pmr::memory_resource*) { return EmulatedMemory::the().allocate(bytes); }
  static void release(void*, std::size_t, std::pmr::memory_resource*) { EmulatedMemory::the().release(); }
  template <class T>
  static void fill(T* to, std::size_t count, const T& value) {
    if (kept_launches) return kept_launches->push_back([=] { fill(to, count, value); });
    const EmulatedMemory::Open open;
    Memory<Serial>::fill(to, count, value);
  }
  template <class T>
  static void copy_in(const T* from, std::size_t count, T* to) {
    synchronize(Blocks{}), require_host(reinterpret_cast<std::uintptr_t>(from));
    copy(from, count, to);
  }
  template <class T>
  static void copy_out(const T* from, std::size_t count, T* to) {
    synchronize(Blocks{}), ++reads();
    require_host(reinterpret_cast<std::uintptr_t>(to));
    copy(from, count, to);
  }
  template <class T>
  static void copy(const T* from, std::size_t count, T* to) {
    if (kept_launches) return kept_launches->push_back([=] { copy(from, count, to); });
    const EmulatedMemory::Open open;
    Memory<Serial>::copy_in(from, count, to);
  }
  template <class T>
  static bool has(const T* from, std::size_t count, const T& value) {
    synchronize(Blocks{}), ++reads();
    const EmulatedMemory::Open open;
    return Memory<Serial>::has(from, count, value);
  }
  static constexpr bool kOnHost = false;
  /// The number of times that the host has waited for the device.
  static int& reads() {
    static int all = 0;
    return all;
  }

 private:
  static void require_host(std::uintptr_t address) {
    if (EmulatedMemory::the().has(address))
      throw std::logic_error("a copy between the host and a device has both ends on the device");
  }
};

/// Finds kernels that were launched with an address of host memory in them, which a device could not read. Numbers that
/// happen to look like an address would be reported too.
class HostAddresses {
 public:
  static std::set<std::string>& kernels_found() {
    static std::set<std::string> names;
    return names;
  }
#if __has_builtin(__builtin_clear_padding)
  static constexpr bool kCanCheck = true;
#else
  static constexpr bool kCanCheck = false;  // clang: the padding between the members of a kernel may have any bits
#endif
  /// Checks the first launch of each kind of kernel.
  template <class Kernel>
  static void check_launch([[maybe_unused]] Kernel kernel) {
#if __has_builtin(__builtin_clear_padding)
    static bool looked = false;
    if (looked || sizeof(Kernel) < sizeof(std::uintptr_t)) return;
    looked = true;
    __builtin_clear_padding(&kernel);
    std::vector<std::uintptr_t> words(sizeof(Kernel) / sizeof(std::uintptr_t));
    std::memcpy(words.data(), static_cast<const void*>(&kernel), words.size() * sizeof(std::uintptr_t));
    if (std::ranges::any_of(words, of_the_host)) kernels_found().insert(kernel_name<Kernel>());
#endif
  }

 private:
  static bool of_the_host(std::uintptr_t word) {
    if (word < 4096 || EmulatedMemory::the().has(word)) return false;
    std::ifstream maps("/proc/self/maps");
    std::string line;
    while (std::getline(maps, line)) {
      std::uintptr_t begin = 0, end = 0;
      if (std::sscanf(line.c_str(), "%lx-%lx", &begin, &end) == 2 && word >= begin && word < end) return true;
    }
    return false;
  }
};

/// The threads of a block, as fibers.
class BlockFibers {
 public:
  struct Thread {
    BlockFibers* all;
    int number;
    int rank() const { return number; }
    int count() const { return static_cast<int>(all->lanes_.size()); }
    void wait(int items) const { all->wait(number, items); }
    template <class Value, class Add>
    Value reduced(const Value& own, Value sum, const Add& add) const {
      all->gathered_.resize(count() * sizeof(Value));
      std::memcpy(all->gathered_.data() + number * sizeof(Value), &own, sizeof(Value));
      all->wait(number, -2);
      for (int k = 0; k < count(); ++k) {
        Value one = own;
        std::memcpy(static_cast<void*>(&one), all->gathered_.data() + k * sizeof(Value), sizeof(Value));
        add(sum, one);
      }
      all->wait(number, -3);
      return sum;
    }
  };

  BlockFibers(int threads, unsigned seed) : lanes_(threads), order_(threads), random_(seed) {
    std::iota(order_.begin(), order_.end(), 0);
  }

  /// Runs work(Thread) on each thread.
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
    int items = -1;  // identifies the barrier at which it waits
  };
  static boost::context::pooled_fixedsize_stack& stacks() {
    // Most of the stack is never touched; but the frame of a patch solve takes 800 KB where clang does not optimise.
    static boost::context::pooled_fixedsize_stack pool(2 * 1024 * 1024);
    return pool;
  }
  void wait(int rank, int items) {
    lanes_[rank].items = items;
    lanes_[rank].scheduler = std::move(lanes_[rank].scheduler).resume();
  }

  std::vector<Lane> lanes_;
  std::vector<int> order_;
  std::vector<char> gathered_;  // the values of a reduction, one of each thread
  std::mt19937 random_;
};

/// Calls work for 0 .. n - 1 in a shuffled order.
template <class Work>
void shuffled(int n, unsigned seed, const Work& work) {
  constexpr int kStep = 7919;  // a prime: it reaches all numbers below n unless it divides n
  const long long step = n % kStep == 0 ? 1 : kStep;
  for (int k = 0; k < n; ++k) work(static_cast<int>((k * step + seed) % n));
}

inline bool is_timed(const Blocks&) { return false; }
inline bool is_leader(const Blocks&) { return true; }
inline Blocks single_threaded(const Blocks& executor) { return executor; }
inline OpenMP on_host(const Blocks& executor) { return {1, executor.instructions}; }

template <class Work>
void parallel_region(const Blocks& executor, int /*width*/, const Work& work) {
  work(executor);
}

template <class Kernel>
void parallel_for(const Blocks& executor, int n, const Kernel& kernel, int grain = kParticleGrain) {
  if (kept_launches) return kept_launches->push_back([=] { parallel_for(executor, n, kernel, grain); });
  note_launch(kernel, n);
  HostAddresses::check_launch(kernel);
  const EmulatedMemory::Open open;
  shuffled(n, executor.seed, kernel);
}

/// Scratch memory is the group's own, and filled with NaN, zeros, or another pattern. Only kernels that run on one
/// thread a group find what their caller has left there.
template <class Kernel>
void parallel_groups(const Blocks& executor, int begin, int end, const ScratchMemory& memory, const Kernel& kernel) {
  if (kept_launches) return kept_launches->push_back([=] { parallel_groups(executor, begin, end, memory, kernel); });
  note_launch(kernel, end - begin);
  HostAddresses::check_launch(kernel);
  const EmulatedMemory::Open open;
  std::vector<double> fast(memory.bytes / sizeof(double) + 8);
  constexpr int kFill[] = {0xff, 0x00, 0x7f};
  shuffled(end - begin, executor.seed, [&](int k) {
    std::memset(fast.data(), kFill[executor.seed % 3], fast.size() * sizeof(double));
    void* aligned = reinterpret_cast<void*>((reinterpret_cast<std::uintptr_t>(fast.data()) + 63) / 64 * 64);
    if constexpr (kShared<Kernel>)
      BlockFibers(std::min(executor.block, kThreads<Kernel>), executor.seed + static_cast<unsigned>(begin + k))
          .run([&](const BlockFibers::Thread& thread) {
            kernel(Block<BlockFibers::Thread>{begin + k, aligned, thread});
          });
    else
      kernel(Group<OneLane>{begin + k, -1, memory.data ? memory.data : aligned});
  });
}

/// Launches are recorded once for a key, and replayed from then on: an incomplete key shows in the results.
template <>
struct Recording<Blocks> {
  std::map<std::string, std::vector<std::function<void()>>> replays;
};
template <class Key, class Work>
void repeated(const Blocks& /*executor*/, Recording<Blocks>& recording, const Key& key, const Work& work) {
  if (kept_launches) return work();
  std::vector<std::function<void()>> launches;
  const std::string own = key();
  if (!recording.replays.contains(own)) {
    const ScopedValue<std::vector<std::function<void()>>*> keep(kept_launches, &launches);
    work();
    recording.replays[own] = launches;
  }
  const ScopedValue<bool> replay(replaying, true);
  for (const auto& launch : recording.replays[own]) launch();
}
template <class Key, class Work>
void repeated_region(const Blocks& executor, int /*width*/, Recording<Blocks>& recording, const Key& key,
                     const Work& work) {
  repeated(executor, recording, key, [&] { work(executor); });
}

/// The sums of groups, in the emulated device's memory.
template <class Value, class Kernel>
Value* partial_sums(const Blocks& executor, int n, const ReducePlan& plan, const Kernel& kernel) {
  const std::size_t sums = plan.all + std::size_t(kReduceGroups);
  auto* const partial = static_cast<Value*>(EmulatedMemory::the().scratch(sums * sizeof(Value)));
  Value* const of_run = partial + kReduceGroups;
  parallel_for(executor, plan.all, ReduceRun<Value, Kernel>{of_run, kernel, n});
  parallel_for(executor, plan.groups, JoinRuns<Value>{of_run, partial, plan.all, plan.runs});
  return partial;
}
template <class Value, class Kernel>
Value parallel_reduce(const Blocks& executor, int n, const Kernel& kernel, int /*grain*/ = kParticleGrain) {
  const ReducePlan plan(n);
  std::vector<Value> sums(kReduceGroups, Value{});
  Memory<Blocks>::copy_out(partial_sums<Value>(executor, n, plan, kernel), plan.groups, sums.data());
  return sum_of_tree(sums.data(), plan.groups);
}
template <class Value, class Kernel>
void parallel_reduce_into(const Blocks& executor, int n, const Kernel& kernel, Value* to,
                          int /*grain*/ = kParticleGrain) {
  const ReducePlan plan(n);
  parallel_for(executor, 1, JoinGroups<Value>{partial_sums<Value>(executor, n, plan, kernel), to, plan.groups});
}

/// Kernels that query the host run in host memory.
template <class Kernel>
void parallel_for_interleaved(const Blocks& executor, int groups, const Kernel& kernel,
                              const ScratchMemory& memory = {}) {
  if constexpr (kRunsOnHost<Kernel>)
    parallel_for_interleaved(Serial{executor.instructions}, groups, kernel);
  else
    parallel_groups(executor, 0, groups, memory, kernel);
}

}  // namespace malha
