// The compute abstraction, and the only file that knows a backend: views, executors and the launches.
// A kernel is a named functor with `KERNEL void operator()(int item) const`. The partition of the work depends on the
// item count alone, never on the number of threads, so that results are the same bits on any number of them.
#pragma once
#if defined(_OPENMP)
#include <omp.h>
#endif

#if defined(__CUDACC__)
#define KERNEL __host__ __device__ inline
#else
#define KERNEL [[gnu::always_inline]] inline
#endif

namespace malha {

/// `size` elements of T that somebody else owns.
template <class T>
struct View {
  T* data = nullptr;
  int size = 0;
  KERNEL T& operator[](int i) const { return data[i]; }
};

/// One thread, no parallel region.
struct Serial {};

/// A fixed number of OpenMP threads.
struct OpenMP {
  int threads = 1;
};

/// As many threads as the backend offers: OMP_NUM_THREADS, or the cores.
inline int available_threads() {
#if defined(_OPENMP)
  return omp_get_max_threads();
#else
  return 1;
#endif
}

/// Up to this many items a launch runs on one thread. By count, never by clock: about 30 microseconds of work, well
/// above a fork-join, and where cores are shared with other programs each fork-join may cost a turn of the scheduler.
inline constexpr int kParticleGrain = 32768;
inline constexpr int kPackGrain = 1024;

/// Runs kernel(0) .. kernel(n - 1) in any order: their writes must be disjoint.
template <class Kernel>
void parallel_for(const Serial&, int n, const Kernel& kernel, int /*grain*/ = kParticleGrain) {
  for (int i = 0; i < n; ++i) kernel(i);
}

template <class Kernel>
void parallel_for(const OpenMP& executor, int n, const Kernel& kernel, int grain = kParticleGrain) {
  if (n <= grain || executor.threads == 1) return parallel_for(Serial{}, n, kernel);
#pragma omp parallel for schedule(static) num_threads(executor.threads)
  for (int i = 0; i < n; ++i) kernel(i);
}

/// Runs kernel(0) .. kernel(groups - 1), each a large piece of work with memory of its own, one core (or thread block)
/// to a group.
template <class Kernel>
void parallel_groups(const Serial&, int groups, const Kernel& kernel) {
  for (int g = 0; g < groups; ++g) kernel(g);
}

template <class Kernel>
void parallel_groups(const OpenMP& executor, int groups, const Kernel& kernel) {
  if (groups == 1 || executor.threads == 1) return parallel_groups(Serial{}, groups, kernel);
#pragma omp parallel for schedule(static) num_threads(executor.threads)
  for (int g = 0; g < groups; ++g) kernel(g);
}

/// At most this many partial results, each of at least kReduceChunk items.
inline constexpr int kReduceGroups = 64;
inline constexpr int kReduceChunk = 256;

template <class Value, class Kernel>
struct ReduceGroup {
  Value* partial;
  const Kernel* kernel;
  int n, chunk;
  KERNEL void operator()(int g) const {
    Value sum{};
    const int end = n < (g + 1) * chunk ? n : (g + 1) * chunk;
    for (int i = g * chunk; i < end; ++i) sum += (*kernel)(i);
    partial[g] = sum;
  }
};

/// The sum of kernel(0) .. kernel(n - 1), added in fixed chunks and then as a fixed tree. Value{} is the zero of `+=`.
/// The kernel may also write, disjointly.
template <class Value, class Executor, class Kernel>
Value parallel_reduce(const Executor& executor, int n, const Kernel& kernel, int grain = kParticleGrain) {
  Value partial[kReduceGroups] = {};
  int chunk = (n + kReduceGroups - 1) / kReduceGroups;
  if (chunk < kReduceChunk) chunk = kReduceChunk;
  const int groups = (n + chunk - 1) / chunk;
  const ReduceGroup<Value, Kernel> group{partial, &kernel, n, chunk};
  if (n <= grain)
    parallel_groups(Serial{}, groups, group);
  else
    parallel_groups(executor, groups, group);
  for (int stride = 1; stride < groups; stride *= 2)
    for (int g = 0; g + stride < groups; g += 2 * stride) partial[g] += partial[g + stride];
  return partial[0];
}

}  // namespace malha
