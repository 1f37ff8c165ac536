// SPDX-License-Identifier: Apache-2.0
// Work on several threads that may throw, as all does that asks for memory: no exception may leave a parallel region.
#pragma once
#include <exception>
#include <mutex>

#include "kernels/parallel/compute.h"

namespace malha {

/// As parallel_for. What the first of the tasks threw is thrown when all are done.
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
