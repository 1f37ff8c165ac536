// SPDX-License-Identifier: Apache-2.0
// Rest values are stored once for a run in which they are all equal, and one by one elsewhere.
#include "host/projection/rest_values.h"

#include <gtest/gtest.h>

#include <limits>

#include "kernels/projection/project_constraint.h"

namespace malha {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

Batch batch_of(int set, int slot, int count, bool run) {
  Batch batch{};
  batch.set = set, batch.slot = slot, batch.count = count, batch.run = run;
  return batch;
}

/// Rest values as the kernels read them: n values a slot.
template <int n>
std::vector<float> read_back(const RestValues<float>& rest, const Batch& batch) {
  std::vector<float> values;
  using S = Lane<float>;
  for (int at = 0; at < batch.count; at += kLanes<float>) {
    const auto of = batch.uniform_rest
                        ? RestOfAll<float, n>(rest.common.data() + batch.common, rest.valid.data() + batch.rests)
                              .template read<S>(at)
                        : RestOfEach<float, n>{rest.each.data() + batch.rests}.template read<S>(at);
    for (int i = 0; i < kLanes<float> && at + i < batch.count; ++i)
      for (const S& value : of.value) values.push_back(of.valid[i] ? lane(value, i) : kNone);
  }
  return values;
}

void expect_same(const std::vector<float>& a, const std::vector<float>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_TRUE(a[i] == b[i] || (a[i] != a[i] && b[i] != b[i])) << i << ": " << a[i] << ", not " << b[i];
}

TEST(RestValues, AreReadBackAsTheyWereWithTheirPadding) {
  // Two runs with equal values, of which one ends with the word and one does not; a run with different values; a
  // gathered batch.
  std::vector<std::vector<float>> values(4);
  for (int i = 0; i < 37; ++i) values[0].push_back(i % 5 == 4 ? kNone : 0.25f);
  for (int i = 0; i < 32; ++i) values[1].push_back(0.5f);
  for (int i = 0; i < 20; ++i) values[2].push_back(i % 7 == 6 ? kNone : float(i));
  for (int i = 0; i < 9; ++i) values[3].push_back(3);
  std::vector<float> by_slot;
  std::vector<Batch> batches;
  for (int k = 0; k < 4; ++k) {
    batches.push_back(batch_of(5, static_cast<int>(by_slot.size()), static_cast<int>(values[k].size()), k < 3));
    batches.push_back(batch_of(4, 0, 16, true));  // a batch of another set, which must not be changed
    by_slot.insert(by_slot.end(), values[k].begin(), values[k].end());
    while (by_slot.size() % kSlotPack != 0) by_slot.push_back(kNone);
  }
  const RestValues<float> rest(by_slot, 1, 5, batches);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(batches[2 * k].uniform_rest, k < 2) << k;
    expect_same(read_back<1>(rest, batches[2 * k]), values[k]);
    EXPECT_FALSE(batches[2 * k + 1].uniform_rest);
  }
  EXPECT_EQ(rest.valid.size(), 3u + 2u) << "a word for 16 slots";
  EXPECT_EQ(rest.each.size(), 32u + 16u);
}

TEST(RestValues, OfSeveralNumbersASlotStayTogether) {
  for (const bool uniform_rest : {false, true}) {
    std::vector<float> by_slot;
    for (int i = 0; i < 48; ++i)
      for (int k = 0; k < 3; ++k) by_slot.push_back(i % 9 == 8 || i > 40 ? kNone : float(uniform_rest ? k : 3 * i + k));
    std::vector<Batch> batches{batch_of(0, 0, 41, true)};
    const RestValues<float> rest(by_slot, 3, 0, batches);
    EXPECT_EQ(batches[0].uniform_rest, uniform_rest);
    EXPECT_EQ(rest.each.size(), uniform_rest ? 0u : 3 * 48u);
    by_slot.resize(3 * 41);
    expect_same(read_back<3>(rest, batches[0]), by_slot);
  }
}

TEST(RestValues, ThatDifferInTheirLastNumberAreNotAlike) {
  std::vector<float> by_slot;
  for (int i = 0; i < 16; ++i) by_slot.insert(by_slot.end(), {1, i == 15 ? 3.0f : 2.0f});
  std::vector<Batch> batches{batch_of(0, 0, 16, true)};
  const RestValues<float> rest(by_slot, 2, 0, batches);
  EXPECT_FALSE(batches[0].uniform_rest);
}

}  // namespace
}  // namespace malha
