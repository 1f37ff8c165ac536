// SPDX-License-Identifier: Apache-2.0
// Launches on threads of the program that uses malha: the bits of OpenMP, whatever the threads do with the groups, and
// several simulations on the same ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "malha/simulation.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// Threads that take groups from a list, of any number of callers; a caller takes groups too.
class CallerPool {
 public:
  explicit CallerPool(int threads) {
    for (int t = 0; t < threads; ++t) all_.emplace_back([this] { work(); });
  }
  ~CallerPool() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ends_ = true;
    }
    wake_.notify_all();
    for (std::thread& one : all_) one.join();
  }

  void parallel_for(int groups, const std::function<void(int)>& function) {
    Launch launch{&function, groups, groups};
    std::unique_lock<std::mutex> lock(mutex_);
    launches_.push_back(&launch);
    wake_.notify_all();
    while (launch.next > 0) run_one(launch, lock);
    done_.wait(lock, [&] { return launch.left == 0; });
  }
  long groups() const { return groups_; }

 private:
  struct Launch {
    const std::function<void(int)>* function;
    int next, left;  // groups that nobody has taken, and that have not ended
  };
  /// Groups are taken from the last one on, in the opposite order of a loop.
  void run_one(Launch& launch, std::unique_lock<std::mutex>& lock) {
    const int group = --launch.next;
    if (launch.next == 0) std::erase(launches_, &launch);
    lock.unlock();
    (*launch.function)(group);
    ++groups_;
    lock.lock();
    if (--launch.left == 0) done_.notify_all();
  }
  void work() {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return ends_ || !launches_.empty(); });
      if (ends_) return;
      run_one(*launches_.front(), lock);
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::vector<Launch*> launches_;
  std::vector<std::thread> all_;
  std::atomic<long> groups_{0};
  bool ends_ = false;
};

std::uint64_t hash_of_steps(const Scene& scene, const SimulationOptions& options, int steps = 12) {
  Simulation simulation(scene, options);
  for (int step = 0; step < steps; ++step) simulation.step();
  return simulation.state_hash();
}

class OnThreadsOfTheCaller : public testing::TestWithParam<std::string> {};

// The scenes have patches of several colours, levels, a filter, contacts, self-collision and pressure.
TEST_P(OnThreadsOfTheCaller, GiveTheBitsOfOpenMP) {
  const Scene scene = load_shipped(GetParam());
  const std::uint64_t expected = hash_of_steps(scene, {.threads = 2});
  CallerPool pool(2);
  const auto in_pool = [&pool](int groups, const std::function<void(int)>& function) {
    pool.parallel_for(groups, function);
  };
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(hash_of_steps(scene, {.threads = threads, .parallel_for = in_pool}), expected) << threads;
  EXPECT_GT(pool.groups(), 0);
  // The groups one after the other, backwards.
  const auto in_line = [](int groups, const std::function<void(int)>& function) {
    while (groups > 0) function(--groups);
  };
  EXPECT_EQ(hash_of_steps(scene, {.threads = 4, .parallel_for = in_line}), expected);
}

INSTANTIATE_TEST_SUITE_P(, OnThreadsOfTheCaller,
                         testing::Values("long_cloth", "desbrun_sheet", "rotating_sphere", "folded_sheet", "pillow",
                                         "soft_bunny", "turning_flag"),
                         [](const auto& tested) { return tested.param; });

TEST(CallerThreads, ServeSeveralSimulationsAtOnce) {
  const std::vector<std::string> names{"long_cloth", "folded_sheet", "rotating_sphere"};
  CallerPool pool(2);
  const auto in_pool = [&pool](int groups, const std::function<void(int)>& function) {
    pool.parallel_for(groups, function);
  };
  std::vector<std::uint64_t> found(names.size());
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < names.size(); ++k)
    threads.emplace_back(
        [&, k] { found[k] = hash_of_steps(load_shipped(names[k]), {.threads = 3, .parallel_for = in_pool}); });
  for (std::thread& one : threads) one.join();
  for (std::size_t k = 0; k < names.size(); ++k)
    EXPECT_EQ(found[k], hash_of_steps(load_shipped(names[k]), {.threads = 1})) << names[k];
}

TEST(CallerThreads, RefuseWhatChoosesOtherOnes) {
  const Scene scene = load_shipped("sheet_shear");
  const auto in_line = [](int groups, const std::function<void(int)>& function) {
    for (int g = 0; g < groups; ++g) function(g);
  };
  EXPECT_EQ(
      refusal([&] { Simulation(scene, {.adaptive_threads = true, .parallel_for = in_line}); }),
      "simulation: parallel_for: found adaptive_threads beside it; allowed: threads of the program, or one of these");
  EXPECT_EQ(
      refusal([&] { Simulation(scene, {.parallel_for = in_line, .backend = Backend::Serial}); }),
      "simulation: parallel_for: found another backend than OpenMP beside it; allowed: threads of the program, or "
      "one of these");
}

}  // namespace
}  // namespace malha
