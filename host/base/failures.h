// Exceptions of work that runs on several threads, which must not leave a parallel region.
#pragma once
#include <exception>
#include <mutex>

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

}  // namespace malha
