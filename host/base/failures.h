// Exceptions of work that runs on several threads, which must not leave a parallel region.
#pragma once
#include <exception>
#include <mutex>

#include "kernels/compute.h"

namespace malha {

/// Keeps the first of them until all threads are done.
class Failures {
 public:
  template <class Work>
  void keep(const Work& work) {
    try {
      work();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!first_) first_ = std::current_exception();
    }
  }
  void rethrow() const {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr first_;
};

/// parallel_for of work that may throw, as all does that asks for memory: what the first threw is thrown when all are
/// done.
template <class Executor, class Work>
void parallel_tasks(const Executor& executor, int n, const Work& work, int grain = 0) {
  Failures failures;
  const auto task = [&](int i) { failures.keep([&] { work(i); }); };
  parallel_for(executor, n, task, grain);
  failures.rethrow();
}

}  // namespace malha
