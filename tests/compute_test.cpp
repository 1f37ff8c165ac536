#include "kernels/compute.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
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
  std::vector<int> visits(n + 1, 0);  // one more: what lies behind must stay 0
  parallel_for(executor, n, Visit{visits.data()}, grain);
  for (int i = 0; i < n; ++i) ASSERT_EQ(visits[i], 1) << "item " << i << " of " << n;
  EXPECT_EQ(visits[n], 0);

  if (n > 1000) return;
  std::fill(visits.begin(), visits.end(), 0);
  parallel_groups(executor, n, Visit{visits.data()});
  for (int i = 0; i < n; ++i) ASSERT_EQ(visits[i], 1) << "group " << i << " of " << n;
  EXPECT_EQ(visits[n], 0);
}

TEST(ParallelFor, VisitsEveryItemOnceOnEveryExecutor) {
  for (const int n : {0, 1, 2, 7, 255, 1000, kParticleGrain, kParticleGrain + 1, 100000})
    for (const int grain : {0, 1, kPackGrain, kParticleGrain}) {
      expect_every_item_once(Serial{}, n, grain);
      for (const int threads : {1, 2, 3, 8}) expect_every_item_once(OpenMP{threads}, n, grain);
    }
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

/// Of many sizes and both signs, so that a different order of addition gives different bits.
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
    const int additions = std::max(kReduceChunk, (n + kReduceGroups - 1) / kReduceGroups) + 6;
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
