// SPDX-License-Identifier: Apache-2.0
// A pool of threads as programs have one: callers hand in jobs of several groups, which the threads and the callers
// take one by one.
#pragma once
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

class ThreadPool {
 public:
  explicit ThreadPool(int threads) {
    for (int t = 0; t < threads; ++t)
      threads_.emplace_back([this] {
        std::unique_lock<std::mutex> lock(mutex_);
        for (;;) {
          wake_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
          if (ends_) return;
          run_group(*jobs_.front(), lock);
        }
      });
  }
  ~ThreadPool() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ends_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  /// Runs function(0) ... function(groups - 1), and returns when all have ended. Any number of threads may call it.
  void parallel_for(int groups, const std::function<void(int)>& function) {
    Job job{&function, groups, 0, groups};
    std::unique_lock<std::mutex> lock(mutex_);
    jobs_.push_back(&job);
    wake_.notify_all();
    while (job.next < job.groups) run_group(job, lock);
    ended_.wait(lock, [&job] { return job.left == 0; });
  }

 private:
  struct Job {
    const std::function<void(int)>* function;
    int groups, next, left;  // all; the next one to be taken; those that have not ended
  };
  void run_group(Job& job, std::unique_lock<std::mutex>& lock) {
    const int group = job.next++;
    if (job.next == job.groups) std::erase(jobs_, &job);
    lock.unlock();
    (*job.function)(group);
    lock.lock();
    if (--job.left == 0) ended_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable wake_, ended_;
  std::vector<Job*> jobs_;  // with groups that nobody has taken
  std::vector<std::thread> threads_;
  bool ends_ = false;
};
