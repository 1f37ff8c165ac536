// SPDX-License-Identifier: Apache-2.0
// The promises of every executor to its kernels (tests/parallel/compute_test.cpp), tested on emulated blocks of
// threads.
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "host/base/radix_sort.h"
#include "kernels/parallel/sort.h"
#include "tests/numbers.h"
#include "tests/parallel/blocks.h"

namespace malha {
namespace {

struct CountVisits {
  int* visits;
  KERNEL void operator()(int i) const { ++visits[i]; }
};
/// Items of a group, each on one thread.
struct CountGroups {
  int* visits;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    ++visits[group.index];
  }
};

const Blocks kAllBlocks[] = {{1, 3}, {32, 1}, {128, 2}};

TEST(BlocksLaunch, EveryItemAndEveryGroupOnce) {
  for (const Blocks& executor : kAllBlocks)
    for (const int n : {0, 1, 2, 255, 7919, 20000}) {
      const std::vector<int> once(n, 1);
      const Array<Blocks, int> items(n, 0), pieces(n, 0), groups(n, 0), dealt(n, 0);
      parallel_for(executor, n, CountVisits{items.data()});
      EXPECT_EQ(items.download(), once);
      parallel_pieces(executor, n, 100, CountVisits{pieces.data()});
      EXPECT_EQ(pieces.download(), once);
      parallel_groups(executor, 0, n, {}, CountGroups{groups.data()});
      EXPECT_EQ(groups.download(), once);
      parallel_for_interleaved(executor, n, CountGroups{dealt.data()});
      EXPECT_EQ(dealt.download(), once);
    }
}

struct RoundedSum {
  float value = 0;
  KERNEL RoundedSum& operator+=(const RoundedSum& o) {
    value += o.value;
    return *this;
  }
};
struct NumberAt {
  const float* numbers;
  KERNEL RoundedSum operator()(int i) const { return {numbers[i]}; }
};

TEST(BlocksSum, HasTheHostsBitsWhetherItIsReadOrNot) {
  Random random(5);
  for (const int n : {0, 1, 255, 256, 257, 16384, 16385, 100000}) {
    std::vector<float> numbers(n);  // of many sizes, so that in another order the sum has other bits
    for (float& number : numbers) number = static_cast<float>(random() * std::pow(10.0, random(-12, 12)));
    const float expected = parallel_reduce<RoundedSum>(Serial{}, n, NumberAt{numbers.data()}).value;
    const Array<Blocks, float> there(numbers);
    const Array<Blocks, RoundedSum> sum(1, RoundedSum{});
    for (const Blocks& executor : kAllBlocks) {
      EXPECT_TRUE(same_bits(parallel_reduce<RoundedSum>(executor, n, NumberAt{there.data()}).value, expected)) << n;
      parallel_reduce_into(executor, n, NumberAt{there.data()}, sum.data());
      EXPECT_TRUE(same_bits(sum.get(0).value, expected)) << n;
    }
  }
}

TEST(BlocksSort, ByKeyAndKeepTheOrderOfEquals) {
  Random random(3);
  for (const Blocks& executor : kAllBlocks)
    for (const int count : {0, 1, 1000, 20000}) {
      std::vector<Keyed> items;
      for (int i = 0; i < count; ++i) items.push_back({unsigned(random.below(1 << 10)), i});
      Sorter<Blocks> sorter;
      Memory<Blocks>::copy_in(items.data(), items.size(), sorter.items(count));
      sorter.sort(executor, count, 10, 1 << 10);
      std::ranges::stable_sort(items, {}, &Keyed::key);
      std::vector<Keyed> sorted(items.size());
      Memory<Blocks>::copy_out(sorter.sorted(), sorted.size(), sorted.data());
      for (int i = 0; i < count; ++i) ASSERT_EQ(sorted[i].value, items[i].value) << i << " of " << count;
    }
}

TEST(BlocksSort, SumWhatComesBefore) {
  Random random(4);
  for (const Blocks& executor : kAllBlocks)
    for (const int count : {0, 1, 8191, 8192, 50000}) {
      std::vector<int> values(count), expected(count);
      for (int& value : values) value = random.below(9);
      std::exclusive_scan(values.begin(), values.end(), expected.begin(), 0);
      const Array<Blocks, int> there(values);
      ScratchBuffer<Blocks, int> memory;
      EXPECT_EQ(running_sum(executor, there.data(), count, memory), std::accumulate(values.begin(), values.end(), 0));
      EXPECT_EQ(there.download(), expected);
    }
}

}  // namespace
}  // namespace malha
