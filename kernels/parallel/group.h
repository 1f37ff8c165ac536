// SPDX-License-Identifier: Apache-2.0
// A large piece of work with fast memory of its own: a core and its caches, or a block of a device's threads and the
// memory that they share. Kernels over groups are written once, for any of both.
#pragma once
#include "kernels/parallel/instructions.h"

namespace malha {

/// Worked on by one core.
template <class InstructionSet>
struct Group {
  using Isa = InstructionSet;
  int index;
  int next;  // the group that this core works on afterwards; none: below 0
  void* memory;

  /// Runs work(0) .. work(items - 1), in any order or at once, and is done with all of them afterwards.
  template <class Work>
  KERNEL void for_each(int items, const Work& work) const {
    for (int i = 0; i < items; ++i) work(i);
  }

  /// Runs work(begin, end) for parts that make up 0 .. items - 1, each of at most `size` where there are many threads.
  template <class Work>
  KERNEL void for_each_chunk(int items, int /*size*/, const Work& work) const {
    work(0, items);
  }

  /// Runs work(begin) .. work(end - 1), one after the other, as a function that is compiled on its own.
  template <class Work>
  KERNEL void call_outlined(int begin, int end, const Work& work) const {
    run(Isa{}, work, begin, end);
  }

  /// What work(0) .. work(items - 1) give, added to `zero` by add(to, one) in any order, which must not matter: numbers
  /// of things, the least and the largest. As in for_each, work may write.
  template <class Value, class Work, class Add>
  KERNEL Value reduce(int items, Value zero, const Work& work, const Add& add) const {
    for (int i = 0; i < items; ++i) add(zero, work(i));
    return zero;
  }

  /// The same memory, for the group `other`.
  KERNEL Group at(int other) const { return {other, -1, memory}; }

  /// for_each of work in three parts, of items that share nothing they write: what the next item reads is read before
  /// this one is written, so that a core computes the one while it loads and stores the others.
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

/// Worked on by many threads, as one of them sees it. Each runs the whole kernel; what for_each is given is dealt to
/// them, and they wait for each other after it. So a kernel may not write outside of for_each, but for what is the
/// same of all threads, and all of them must come to each for_each.
/// Threads: rank() of this one, count() of them, wait(items) for all, after a for_each of so many, and
/// gathered(own, zero, add), what all have.
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

/// Whether a kernel over groups shares its work in the ways above: a block of many threads may run it. Any other takes
/// one thread a group.
template <class Kernel>
inline constexpr bool kShared = requires {
  typename Kernel::Shared;
};

/// How many threads of a block it can make use of.
template <class Kernel>
inline constexpr int kThreads = 1024;
template <class Kernel>
requires requires { Kernel::kMostThreads; }
inline constexpr int kThreads<Kernel> = Kernel::kMostThreads;

/// Whether a kernel asks what only the host can answer (Embree): a device's executor leaves it to the host.
template <class Kernel>
inline constexpr bool kRunsOnHost = requires {
  typename Kernel::RunsOnHost;
};

/// The number of the lowest bit that is set.
KERNEL int lowest_bit(unsigned long long bits) {
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(bits)) - 1;
#else
  return __builtin_ctzll(bits);
#endif
}

/// Asks for the cache line at `address` ahead of its use. Whatever lies there, even nothing, is harmless.
KERNEL void prefetch([[maybe_unused]] const void* address) {
#if !defined(__CUDACC__)
  __builtin_prefetch(address, 0, 2);
#endif
}

/// The same for all lines of `bytes`, a constant.
KERNEL void prefetch(const void* address, int bytes) {
  for (int line = 0; line < bytes; line += 64) prefetch(static_cast<const char*>(address) + line);
}

}  // namespace malha
