// SPDX-License-Identifier: Apache-2.0
// Parallel loops whose tasks may throw, as any allocation may: no exception may leave a parallel region.
#pragma once
#include <exception>
#include <mutex>

#include "kernels/parallel/compute.h"

namespace malha {

/// As parallel_for. The first exception of a task is rethrown when all are done.
template <class Executor, class Work>
void parallel_tasks(const Executor& executor, int n, const Work& work, int grain = 0) {
  std::exception_ptr first;
  std::mutex mutex;
  const auto task = [&](int i) {
    try {
      work(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!first) first = std::current_exception();
    }
  };
  parallel_for(executor, n, task, grain);
  if (first) std::rethrow_exception(first);
}

}  // namespace malha
