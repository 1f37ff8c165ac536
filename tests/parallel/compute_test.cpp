// SPDX-License-Identifier: Apache-2.0
#include "kernels/parallel/compute.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <thread>
#include <type_traits>
#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

struct Visit {
  int* visits;
  void operator()(int i) const { ++visits[i]; }
};

template <class Executor>
void expect_every_item_once(const Executor& executor, int n, int grain) {
  std::vector<int> visits(n + 1, 0);  // one more: the number behind the end must stay 0
  parallel_for(executor, n, Visit{visits.data()}, grain);
  for (int i = 0; i < n; ++i) ASSERT_EQ(visits[i], 1) << "item " << i << " of " << n;
  EXPECT_EQ(visits[n], 0);
}

TEST(ParallelFor, VisitsEveryItemOnceOnEveryExecutor) {
  for (const int n : {0, 1, 2, 7, 255, 1000, kParticleGrain, kParticleGrain + 1, 100000})
    for (const int grain : {0, 1, 1000, kParticleGrain}) {
      expect_every_item_once(Serial{}, n, grain);
      for (const int threads : {1, 2, 3, 8}) expect_every_item_once(OpenMP{threads}, n, grain);
    }
}

struct NoteMemory {
  int* visits;
  void** memory;
  int* next;
  template <class Group>
  void operator()(const Group& group) const {
    ++visits[group.index];
    memory[group.index] = group.memory;
    next[group.index] = group.next;
  }
};

TEST(ParallelGroups, VisitEveryGroupOnceAndGiveItTheMemoryOfItsThread) {
  constexpr int n = 20;
  constexpr std::size_t bytes = 100;
  const auto expect = [&](const auto& executor, int threads, int begin, int end) {
    std::vector<char> fast(threads * bytes);
    std::vector<int> visits(n, 0), next(n);
    std::vector<void*> first(n), second(n);
    for (std::vector<void*>* memory : {&first, &second})
      parallel_region(executor, threads, [&](const auto& team) {
        parallel_groups(team, begin, end, {fast.data(), bytes}, NoteMemory{visits.data(), memory->data(), next.data()});
      });
    for (int g = 0; g < n; ++g) {
      ASSERT_EQ(visits[g], g >= begin && g < end ? 2 : 0) << g << " of " << begin << " to " << end;
      if (visits[g] == 0) continue;
      EXPECT_EQ(first[g], second[g]) << "the same thread every time";
      const bool another = g + 1 < end && first[g + 1] == first[g];
      EXPECT_EQ(next[g], another ? g + 1 : -1) << "what the same thread visits afterwards";
      const std::ptrdiff_t at = static_cast<char*>(first[g]) - fast.data();
      EXPECT_TRUE(at >= 0 && at < static_cast<std::ptrdiff_t>(fast.size()) && at % bytes == 0) << at;
    }
  };
  for (const int begin : {0, 3})
    for (const int end : {begin, begin + 1, begin + 2, begin + 7, n}) {
      expect(Serial{}, 1, begin, end);
      for (const int threads : {1, 2, 3, 8}) expect(OpenMP{threads}, threads, begin, end);
    }
}

struct AddToNeighbour {
  const int* from;
  int* to;
  int n;
  template <class Group>
  void operator()(const Group& group) const {
    to[group.index] = from[(group.index + 1) % n] + 1;
  }
};

TEST(ParallelGroups, AreDoneBeforeTheNextLaunch) {
  constexpr int n = 16, launches = 1000;
  for (const int threads : {1, 2, 3, 8}) {
    std::vector<int> a(n, 0), b(n, 0);
    parallel_region(OpenMP{threads}, threads, [&](const auto& team) {
      for (int k = 0; k < launches; k += 2) {
        parallel_groups(team, 0, n, {}, AddToNeighbour{a.data(), b.data(), n});
        parallel_groups(team, 0, n, {}, AddToNeighbour{b.data(), a.data(), n});
      }
    });
    EXPECT_EQ(a, std::vector<int>(n, launches)) << threads << " threads";
  }
}

TEST(ParallelGroups, RunEveryItemOfAGroupOnce) {
  std::vector<int> visits(8, 0);
  Group<NativeIsa>{0, -1, nullptr}.for_each(7, Visit{visits.data()});
  EXPECT_EQ(visits, (std::vector<int>{1, 1, 1, 1, 1, 1, 1, 0}));
}

TEST(ParallelRegion, HasNoMoreThreadsThanItsWidth) {
  for (const int width : {0, 1, 2, 5}) {
    std::atomic<int> threads = 0;
    parallel_region(OpenMP{4}, width, [&](const auto&) { ++threads; });
    EXPECT_LE(threads, std::max(1, std::min(width, 4)));
    EXPECT_GE(threads, 1);
  }
}

TEST(ParallelRegion, OfOneThreadHasNoTeam) {
  const auto expect_serial = [](const auto& executor, int width) {
    parallel_region(executor, width,
                    [](const auto& team) { EXPECT_TRUE((std::is_same_v<std::decay_t<decltype(team)>, Serial>)); });
  };
  expect_serial(Serial{}, 8), expect_serial(OpenMP{1}, 8), expect_serial(OpenMP{8}, 1);
}

/// The number of a thread in its region.
int thread_of(const Serial&) { return 0; }
int thread_of(const Team& team) { return team.thread; }
int threads_of(const Serial&) { return 1; }
int threads_of(const Team& team) { return team.threads; }

TEST(ParallelRegion, NumbersTheThreadsOfItsTeam) {
  for (const int wanted : {1, 2, 3, 8}) {
    std::vector<std::atomic<int>> seen(wanted), sizes(wanted);
    parallel_region(OpenMP{wanted}, 100, [&](const auto& team) {
      ++seen.at(thread_of(team));
      sizes.at(thread_of(team)) = threads_of(team);
    });
    const int threads = sizes[0];
    for (int t = 0; t < wanted; ++t) {
      EXPECT_EQ(seen[t], t < threads ? 1 : 0) << t << " of " << threads;
      EXPECT_EQ(sizes[t], t < threads ? threads : 0) << t << " of " << threads;
    }
  }
}

// Also with more threads than cores: threads that spin yield to those that have not arrived yet.
TEST(Barrier, ReleasesNoThreadBeforeTheLastArrives) {
  constexpr int rounds = 2000;
  for (const int wanted : {1, 2, 3, 8}) {
    Barrier barrier;
    std::vector<std::atomic<int>> reached(wanted);
    std::atomic<int> early = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < wanted; ++t)
      threads.emplace_back([&, t] {
        for (int round = 1; round <= rounds; ++round) {
          reached[t].store(round, std::memory_order_relaxed);
          barrier.wait(wanted);
          for (const auto& other : reached) early += other.load(std::memory_order_relaxed) < round;
        }
      });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(early, 0) << wanted << " threads";
  }
}

TEST(Barrier, MakesWhatTheOthersWroteVisible) {
  constexpr int rounds = 2000, threads = 3;
  Barrier barrier;
  int written[threads] = {};  // plain: the barrier alone orders the accesses
  std::atomic<int> stale = 0;
  std::vector<std::thread> team;
  for (int t = 0; t < threads; ++t)
    team.emplace_back([&, t] {
      for (int round = 1; round <= rounds; ++round) {
        written[t] = round;
        barrier.wait(threads);
        for (const int other : written) stale += other != round;
        barrier.wait(threads);
      }
    });
  for (std::thread& thread : team) thread.join();
  EXPECT_EQ(stale, 0);
}

struct FloatSum {
  float value = 0;
  FloatSum& operator+=(const FloatSum& o) {
    value += o.value;
    return *this;
  }
};

struct Item {
  const float* values;
  FloatSum operator()(int i) const { return {values[i]}; }
};

/// Numbers of many sizes and both signs, so that a different order of addition gives different bits.
std::vector<float> badly_scaled(int n) {
  Random random(7);
  std::vector<float> values(n);
  for (float& value : values) value = static_cast<float>(random() * std::pow(10.0, random(-12, 12)));
  return values;
}

const int kSizes[] = {0, 1, 2, 255, 256, 257, 16383, 16384, 16385, 1000000};

TEST(ParallelReduce, GivesTheSameBitsOnEveryExecutor) {
  for (const int n : kSizes) {
    const std::vector<float> values = badly_scaled(n);
    const float serial = parallel_reduce<FloatSum>(Serial{}, n, Item{values.data()}).value;
    for (const int threads : {1, 2, 3, 8}) {
      const float sum = parallel_reduce<FloatSum>(OpenMP{threads}, n, Item{values.data()}).value;
      EXPECT_TRUE(same_bits(sum, serial)) << n << " items, " << threads << " threads";
    }
  }
}

TEST(ParallelReduce, IsTheSumToRounding) {
  for (const int n : kSizes) {
    const std::vector<float> values = badly_scaled(n);
    long double exact = 0, sizes = 0;
    for (const float value : values) exact += value, sizes += std::fabs(value);
    const float sum = parallel_reduce<FloatSum>(Serial{}, n, Item{values.data()}).value;
    // Each number passes through at most a chunk of additions and six levels of the tree, each with half an ulp.
    const int additions = kReduceRun + ReducePlan(n).runs + 6;
    EXPECT_LE(std::fabs(sum - exact), additions * 0.5L * std::numeric_limits<float>::epsilon() * sizes) << n;
  }
}

struct Count {
  long long value = 0;
  Count& operator+=(const Count& o) {
    value += o.value;
    return *this;
  }
};

struct Index {
  Count operator()(int i) const { return {i + 1LL}; }
};

TEST(ParallelReduce, CountsEveryItemOnce) {
  for (const long long n : kSizes)
    for (const int threads : {1, 3})
      EXPECT_EQ(parallel_reduce<Count>(OpenMP{threads}, static_cast<int>(n), Index{}).value, n * (n + 1) / 2) << n;
}

/// The smallest item; its zero is above all of them.
struct Least {
  int value = std::numeric_limits<int>::max();
  Least& operator+=(const Least& o) {
    value = std::min(value, o.value);
    return *this;
  }
};

struct Falling {
  Least operator()(int i) const { return {1000 - i}; }
};

TEST(ParallelReduce, StartsFromTheZeroOfItsValueType) {
  EXPECT_EQ(parallel_reduce<Least>(OpenMP{2}, 0, Falling{}).value, std::numeric_limits<int>::max());
  EXPECT_EQ(parallel_reduce<Least>(OpenMP{2}, 900, Falling{}).value, 101);
}

}  // namespace
}  // namespace malha
