// SPDX-License-Identifier: Apache-2.0
// Executors and launches: the compute abstraction, and the only file that depends on a host backend.
// A kernel is a named functor with `KERNEL void operator()(int item) const`. The partition of the work depends on the
// item count alone, never on the number of threads, so that results are the same bits on any number of them.
#pragma once
#include <sched.h>
#include <stddef.h>
#if defined(_OPENMP)
#include <omp.h>
#endif

#include "kernels/parallel/group.h"

namespace malha {

#if defined(_OPENMP)
inline constexpr bool kHasOpenMP = true;
#else
inline constexpr bool kHasOpenMP = false;
#endif

/// One thread, no parallel region.
struct Serial {
  Instructions instructions = widest_instructions();
};

/// Threads of the program that uses malha. call(context, groups, function, data) runs function(data, 0) ...
/// function(data, groups - 1), each once, on any threads and in any order, and returns when all have returned. No group
/// waits for another one, so that any number of them may run at a time.
struct CallerThreads {
  void* context;
  void (*call)(void* context, int groups, void (*function)(const void* data, int group), const void* data);
  template <class Function>
  void run(int groups, const Function& function) const {
    call(
        context, groups, [](const void* data, int group) { (*static_cast<const Function*>(data))(group); }, &function);
  }
};

/// A fixed number of threads: OpenMP's, or, with `caller`, as many groups of a launch on threads of the caller.
struct OpenMP {
  OpenMP(int threads_ = 1, Instructions instructions_ = widest_instructions(), const CallerThreads* caller_ = nullptr)
      : threads(threads_), instructions(instructions_), caller(caller_) {}
  OpenMP(const Serial& serial) : OpenMP(1, serial.instructions) {}
  int threads;
  Instructions instructions;
  const CallerThreads* caller;
};

/// Number of threads that the backend offers: OMP_NUM_THREADS, or the number of cores.
inline int available_threads() {
#if defined(_OPENMP)
  return omp_get_max_threads();
#else
  return 1;
#endif
}

/// Number of host threads of an executor.
template <class Executor>
int threads_of(const Executor& executor) {
  if constexpr (requires { executor.threads; })
    return executor.threads;
  else
    return 1;
}

inline constexpr int kAllThreads = 1 << 30;
/// Limits the threads of launches of this thread, whatever their executor has.
inline thread_local int max_threads = kAllThreads;

/// Barrier of a team's threads. A fork and a join cost tens of times as much.
class Barrier {
 public:
  void wait(int threads) {
    const unsigned round = __atomic_load_n(&round_, __ATOMIC_RELAXED);
    if (__atomic_add_fetch(&waiting_, 1, __ATOMIC_ACQ_REL) == threads) {
      __atomic_store_n(&waiting_, 0, __ATOMIC_RELAXED);
      __atomic_store_n(&round_, round + 1, __ATOMIC_RELEASE);
      return;
    }
    // The others usually arrive within a microsecond. If they have no core to run on, this thread yields its own.
    for (int spins = 0; __atomic_load_n(&round_, __ATOMIC_ACQUIRE) == round; ++spins)
      if (spins > kSpins) sched_yield();
  }

 private:
  static constexpr int kSpins = 4000;
  alignas(64) int waiting_ = 0;
  alignas(64) unsigned round_ = 0;
};

/// One thread of a parallel region. Every thread runs the same code, takes its share of each launch, and waits for the
/// others at its end. On threads of the caller, which need not run at the same time, one thread runs the code and hands
/// out the shares of each launch.
struct Team {
  int thread, threads;
  Barrier* barrier;
  Instructions instructions;
  const CallerThreads* caller = nullptr;

  /// Runs share(t) for each of the threads t, and waits for all.
  template <class Share>
  void run_shares(const Share& share) const {
    if (caller != nullptr) return caller->run(threads, share);
    share(thread);
    barrier->wait(threads);
  }
};

/// Executor for launches that are cheaper than a fork and a join.
inline Serial single_threaded(const Serial& executor) { return executor; }
inline Serial single_threaded(const OpenMP& executor) { return Serial{executor.instructions}; }

/// Executor for kernels on host memory.
inline Serial on_host(const Serial& executor) { return executor; }
inline OpenMP on_host(const OpenMP& executor) { return executor; }

/// Waits for all launches, to time them. is_timed(): whether passes of an executor are timed.
inline void synchronize(const Serial& /*executor*/) {}
inline void synchronize(const OpenMP& /*executor*/) {}
inline bool is_timed(const Serial& /*executor*/) { return true; }
inline bool is_timed(const OpenMP& /*executor*/) { return true; }

/// Tells whether this is the leading thread of a region, which alone may write what is common to all.
inline bool is_leader(const Serial& /*team*/) { return true; }
inline bool is_leader(const Team& team) { return team.thread == 0; }

/// Runs work(executor), which may have many launches, with one fork and join for all of them. `width`: the largest
/// useful number of threads. `work` runs on every thread, so that apart from its launches it may only read, except on
/// the leading thread.
template <class Work>
void parallel_region(const Serial& executor, int /*width*/, const Work& work) {
  work(executor);
}

template <class Work>
void parallel_region(const OpenMP& executor, int width, const Work& work) {
  const int most = executor.threads < max_threads ? executor.threads : max_threads;
  const int threads = width < most ? width : most;
  if (threads <= 1) return work(Serial{executor.instructions});
  if (executor.caller != nullptr) return work(Team{0, threads, nullptr, executor.instructions, executor.caller});
#if defined(_OPENMP)
  Barrier barrier;
#pragma omp parallel num_threads(threads)
  work(Team{omp_get_thread_num(), omp_get_num_threads(), &barrier, executor.instructions});
#else
  work(Serial{executor.instructions});
#endif
}

/// Observer of launches. `kernel`: as kernel_name() gives it.
struct LaunchObserver {
  virtual void launched(const char* kernel, int items) = 0;

 protected:
  ~LaunchObserver() = default;
};

/// Observer of the launches of this thread, usually null. A team has that of its leading thread.
inline thread_local LaunchObserver* launch_observer = nullptr;

/// The signature of this function, which contains "Kernel = " and the type.
template <class Kernel>
const char* kernel_name() {
  return __PRETTY_FUNCTION__;
}

template <class Kernel>
void note_launch(const Kernel&, int items) {
  if (launch_observer != nullptr) launch_observer->launched(kernel_name<Kernel>(), items);
}

/// Up to this many items a launch runs on one thread. The limit is a count, never a measured time: about 30
/// microseconds of work, well above a fork-join, which may cost a time slice where cores are shared with other
/// programs.
inline constexpr int kParticleGrain = 32768;

/// Runs kernel(0) .. kernel(n - 1) in any order: their writes must be disjoint.
template <class Kernel>
void parallel_for(const Serial&, int n, const Kernel& kernel, int /*grain*/ = kParticleGrain) {
  note_launch(kernel, n);
#pragma omp simd
  for (int i = 0; i < n; ++i) kernel(i);
}

template <class Kernel>
void parallel_for(const OpenMP& executor, int n, const Kernel& kernel, int grain = kParticleGrain) {
  const int threads = executor.threads < max_threads ? executor.threads : max_threads;
  if (n <= grain || threads == 1) return parallel_for(Serial{}, n, kernel);
  note_launch(kernel, n);
  if (executor.caller != nullptr) {
    executor.caller->run(threads, [&kernel, n, threads](int group) {
      const auto begin_of = [n, threads](int g) { return int(static_cast<long long>(n) * g / threads); };
      const int end = begin_of(group + 1);
#pragma omp simd
      for (int i = begin_of(group); i < end; ++i) kernel(i);
    });
    return;
  }
#if defined(_OPENMP)
#pragma omp parallel for simd schedule(static) num_threads(threads)
#endif
  for (int i = 0; i < n; ++i) kernel(i);
}

/// The fast memory of every thread of an executor.
struct ScratchMemory {
  char* data = nullptr;  // null if only blocks of threads, which have their own, need it
  size_t bytes = 0;      // per thread
  char* of(int thread) const { return data ? data + size_t(thread) * bytes : nullptr; }
};

template <class Isa, class Kernel>
struct RunGroup {
  Kernel kernel;
  int last;
  void* memory;
  KERNEL void operator()(int g) const { kernel(Group<Isa>{g, g < last ? g + 1 : -1, memory}); }
};

/// Runs kernel(Group) for the groups begin .. end - 1 on this thread.
template <class Kernel>
void run_groups(Instructions instructions, int begin, int end, void* memory, const Kernel& kernel) {
  bool ran = false;
  for_each_isa([&]<class Isa>(Isa isa) {
    if (Isa::value != instructions) return;
    run(isa, RunGroup<Isa, Kernel>{kernel, end - 1, memory}, begin, end);
    ran = true;
  });
  if (!ran) __builtin_trap();  // the compiler does not know this instruction set
}

/// Runs kernel(Group) for the groups begin .. end - 1, compiled for the executor's instructions: their writes must be
/// disjoint. The same thread gets the same groups every time, which are then in its caches.
template <class Kernel>
void parallel_groups(const Serial& executor, int begin, int end, const ScratchMemory& memory, const Kernel& kernel) {
  note_launch(kernel, end - begin);
  run_groups(executor.instructions, begin, end, memory.data, kernel);
}

template <class Kernel>
void parallel_groups(const Team& team, int begin, int end, const ScratchMemory& memory, const Kernel& kernel) {
  note_launch(kernel, end - begin);
  const auto share = [&](int thread) {
    return begin + int(static_cast<long long>(end - begin) * thread / team.threads);
  };
  team.run_shares(
      [&](int thread) { run_groups(team.instructions, share(thread), share(thread + 1), memory.of(thread), kernel); });
}

/// Maps groups 0, 1, ... to first, first + step, ...
template <class Kernel>
struct Interleaved {
  Kernel kernel;
  int first, step;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    kernel(Group{first + group.index * step, group.next < 0 ? -1 : first + group.next * step, group.memory});
  }
};

/// As parallel_groups, for groups of uneven work: threads get them interleaved, because neighbouring groups have about
/// the same work.
template <class Kernel>
void parallel_for_interleaved(const Serial& executor, int groups, const Kernel& kernel,
                              const ScratchMemory& memory = {}) {
  note_launch(kernel, groups);
  run_groups(executor.instructions, 0, groups, memory.data, Interleaved<Kernel>{kernel, 0, 1});
}

template <class Kernel>
void parallel_for_interleaved(const Team& team, int groups, const Kernel& kernel, const ScratchMemory& memory = {}) {
  note_launch(kernel, groups);
  team.run_shares([&](int thread) {
    const int share = (groups - thread + team.threads - 1) / team.threads;
    run_groups(team.instructions, 0, share, memory.of(thread), Interleaved<Kernel>{kernel, thread, team.threads});
  });
}

/// Group g runs `size` of the items kernel(0) .. kernel(count - 1).
template <class Kernel>
struct Pieces {
  using Shared = void;
  Kernel kernel;
  int count, size;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int begin = group.index * size, end = begin + size < count ? begin + size : count;
    group.for_each(end - begin, [&](int i) KERNEL_LAMBDA { kernel(begin + i); });
  }
};

template <class Kernel>
void note_launch(const Pieces<Kernel>& pieces, int) {
  note_launch(pieces.kernel, pieces.count);
}

/// Runs kernel(0) .. kernel(count - 1) on a team in pieces of `size`, compiled for its instructions: their writes must
/// be disjoint.
template <class Team, class Kernel>
void parallel_pieces(const Team& team, int count, int size, const Kernel& kernel) {
  parallel_groups(team, 0, (count + size - 1) / size, {}, Pieces<Kernel>{kernel, count, size});
}

/// Sum in double, which is exact for counts.
struct Sum {
  double value = 0;
  KERNEL Sum& operator+=(const Sum& o) {
    value += o.value;
    return *this;
  }
};

/// Reductions sum runs of kReduceRun items, then at most kReduceGroups groups of runs, then a tree of groups. Each sum
/// has a fixed order, so that parallel evaluation gives the same bits.
inline constexpr int kReduceRun = 256, kReduceGroups = 64;

/// Sums the groups by a tree, in place.
template <class Value>
KERNEL Value sum_of_tree(Value* partial, int groups) {
  for (int stride = 1; stride < groups; stride *= 2)
    for (int g = 0; g + stride < groups; g += 2 * stride) partial[g] += partial[g + stride];
  return partial[0];
}

/// The sum of run `run` of kernel(0) .. kernel(n - 1).
template <class Value, class Kernel>
KERNEL Value sum_of_run(const Kernel& kernel, int n, int run) {
  Value sum{};
  const int end = n < (run + 1) * kReduceRun ? n : (run + 1) * kReduceRun;
  for (int i = run * kReduceRun; i < end; ++i) sum += kernel(i);
  return sum;
}

template <class Value, class Kernel>
struct ReduceGroup {
  Value* partial;
  Kernel kernel;
  int n, runs;  // runs: of a group
  KERNEL void operator()(int g) const {
    Value sum{};
    for (int run = g * runs; run < (g + 1) * runs && run * kReduceRun < n; ++run)
      sum += sum_of_run<Value>(kernel, n, run);
    partial[g] = sum;
  }
};

template <class Value, class Kernel>
void note_launch(const ReduceGroup<Value, Kernel>& groups, int) {
  note_launch(groups.kernel, groups.n);
}

/// The same in two launches, for devices: first the runs, then (JoinRuns) their groups.
template <class Value, class Kernel>
struct ReduceRun {
  Value* of_run;
  Kernel kernel;
  int n;
  KERNEL void operator()(int run) const { of_run[run] = sum_of_run<Value>(kernel, n, run); }
};
template <class Value, class Kernel>
void note_launch(const ReduceRun<Value, Kernel>& runs, int) {
  note_launch(runs.kernel, runs.n);
}
template <class Value>
struct JoinRuns {
  const Value* of_run;
  Value* partial;
  int all, runs;  // number of runs in all, and of a group
  KERNEL void operator()(int g) const {
    Value sum{};
    for (int run = g * runs; run < (g + 1) * runs && run < all; ++run) sum += of_run[run];
    partial[g] = sum;
  }
};

template <class Value>
struct JoinGroups {
  Value *partial, *to;
  int groups;
  KERNEL void operator()(int) const { *to = sum_of_tree(partial, groups); }
};

/// Partition of a sum over n items.
struct ReducePlan {
  int all, runs, groups;  // runs in all, runs of a group
  explicit ReducePlan(int n)
      : all((n + kReduceRun - 1) / kReduceRun),
        runs((all + kReduceGroups - 1) / kReduceGroups),
        groups(runs > 0 ? (all + runs - 1) / runs : 0) {}
};

/// The sum of kernel(0) .. kernel(n - 1), added in that fixed order. Value{} is the zero of `+=`.
/// The kernel may also write, disjointly.
template <class Value, class Executor, class Kernel>
Value parallel_reduce(const Executor& executor, int n, const Kernel& kernel, int grain = kParticleGrain) {
  Value partial[kReduceGroups] = {};
  const ReducePlan plan(n);
  parallel_for(executor, plan.groups, ReduceGroup<Value, Kernel>{partial, kernel, n, plan.runs},
               n <= grain ? plan.groups : 0);
  return sum_of_tree(partial, plan.groups);
}

/// The same, with the result in the executor's memory and without synchronisation.
template <class Value, class Executor, class Kernel>
void parallel_reduce_into(const Executor& executor, int n, const Kernel& kernel, Value* to,
                          int grain = kParticleGrain) {
  *to = parallel_reduce<Value>(executor, n, kernel, grain);
}

}  // namespace malha
