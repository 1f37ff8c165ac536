// SPDX-License-Identifier: Apache-2.0
// Groups: pieces of work with fast memory of their own, on a core with its caches, or on a block of device threads with
// shared memory. Kernels over groups are written once for both.
#pragma once
#include "kernels/parallel/instructions.h"

namespace malha {

/// A group on one core.
template <class InstructionSet>
struct Group {
  using Isa = InstructionSet;
  int index;
  int next;  // the next group of this core; below 0: none
  void* memory;

  /// Runs work(0) .. work(items - 1), in any order or in parallel, and returns when all are done.
  template <class Work>
  KERNEL void for_each(int items, const Work& work) const {
    for (int i = 0; i < items; ++i) work(i);
  }

  /// Runs work(begin, end) for chunks of 0 .. items - 1, of at most `size` items where there are many threads.
  template <class Work>
  KERNEL void for_each_chunk(int items, int /*size*/, const Work& work) const {
    work(0, items);
  }

  /// Runs work(begin) .. work(end - 1) in order, in a function that is compiled separately.
  template <class Work>
  KERNEL void call_outlined(int begin, int end, const Work& work) const {
    run(Isa{}, work, begin, end);
  }

  /// Reduces work(0) .. work(items - 1), starting from `zero`, by add(to, one) in any order, which must not matter, as
  /// for counts, minima and maxima. As in for_each, work may write.
  template <class Value, class Work, class Add>
  KERNEL Value reduce(int items, Value zero, const Work& work, const Add& add) const {
    for (int i = 0; i < items; ++i) add(zero, work(i));
    return zero;
  }

  /// The group `other` with the same memory.
  KERNEL Group at(int other) const { return {other, -1, memory}; }

  /// Software-pipelined for_each of work in three stages, for items with disjoint writes: the next item is read before
  /// the current one is written, so that a core computes one while it loads and stores the others.
  template <class Work>
  KERNEL void for_each_ahead(int items, const Work& work) const {
    if (items == 0) return;
    auto ahead = work.read(0);
    for (int i = 0; i < items; ++i) {
      auto item = ahead;
      work.compute(i, item);
      ahead = work.read(i + 1 < items ? i + 1 : i);
      work.write(i, item);
    }
  }
};

/// A group on a block of threads, as seen by one of them. Every thread runs the whole kernel; for_each distributes its
/// items over them, with a barrier after it. So a kernel may not write outside of for_each, except what is the same on
/// all threads, and all of them must reach every for_each.
/// Threads: rank() of this one, their count(), wait(items), the barrier after a for_each of so many, and
/// reduced(own, zero, add), the reduction over all.
template <class Threads>
struct Block {
  using Isa = OneLane;
  int index;
  static constexpr int next = -1;
  void* memory;
  Threads threads;

  template <class Work>
  KERNEL void for_each(int items, const Work& work) const {
    for (int i = threads.rank(); i < items; i += threads.count()) work(i);
    threads.wait(items);
  }

  template <class Work>
  KERNEL void for_each_chunk(int items, int size, const Work& work) const {
    for_each((items + size - 1) / size, [&](int part) KERNEL_LAMBDA {
      const int begin = part * size;
      work(begin, begin + size < items ? begin + size : items);
    });
  }

  template <class Work>
  KERNEL void call_outlined(int begin, int end, const Work& work) const {
    KERNEL_ROLLED
    for (int i = begin; i < end; ++i) work(i);
  }

  template <class Value, class Work, class Add>
  KERNEL Value reduce(int items, const Value& zero, const Work& work, const Add& add) const {
    Value own = zero;
    for (int i = threads.rank(); i < items; i += threads.count()) add(own, work(i));
    return threads.reduced(own, zero, add);
  }

  KERNEL Block at(int other) const { return {other, memory, threads}; }

  template <class Work>
  KERNEL void for_each_ahead(int items, const Work& work) const {
    for_each(items, [&](int i) KERNEL_LAMBDA {
      auto item = work.read(i);
      work.compute(i, item);
      work.write(i, item);
    });
  }
};

/// Tells whether a kernel over groups distributes its work in the ways above, so that a block of threads may run it.
/// Any other kernel runs on one thread per group.
template <class Kernel>
inline constexpr bool kShared = requires {
  typename Kernel::Shared;
};

/// The largest useful number of threads of a block.
template <class Kernel>
inline constexpr int kThreads = 1024;
template <class Kernel>
requires requires { Kernel::kMostThreads; }
inline constexpr int kThreads<Kernel> = Kernel::kMostThreads;

/// Tells whether a kernel runs on the host whatever the executor, because it queries Embree.
template <class Kernel>
inline constexpr bool kRunsOnHost = requires {
  typename Kernel::RunsOnHost;
};

KERNEL int count_bits(unsigned bits) {
#if defined(__CUDA_ARCH__)
  return __popc(bits);
#else
  return __builtin_popcount(bits);
#endif
}

/// The number of the lowest bit that is set.
KERNEL int lowest_bit(unsigned long long bits) {
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(bits)) - 1;
#else
  return __builtin_ctzll(bits);
#endif
}

/// Prefetches the cache line at `address`. Invalid addresses are harmless.
KERNEL void prefetch([[maybe_unused]] const void* address) {
#if !defined(__CUDACC__)
  __builtin_prefetch(address, 0, 2);
#endif
}

/// The same for all lines of `bytes`, which should be a constant.
KERNEL void prefetch(const void* address, int bytes) {
  for (int line = 0; line < bytes; line += 64) prefetch(static_cast<const char*>(address) + line);
}

}  // namespace malha
