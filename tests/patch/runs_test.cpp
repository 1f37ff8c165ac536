// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "tests/self_collision/tangles.h"

namespace malha {
namespace {

constexpr int kShortest = 4, kLongestGap = 8;

/// Checks the properties of every result, whatever the constraints.
void expect_sound(const Runs& found, const std::vector<int>& particles, int arity,
                  const std::vector<std::uint8_t>& class_of) {
  const int count = static_cast<int>(particles.size()) / arity;
  const std::vector<bool> movable(class_of.size(), false);
  std::vector<int> seen(count, 0);
  int held = 0;
  for (const Run& run : found.runs) {
    ASSERT_GE(run.slots.front(), 0) << "a run starts with a constraint";
    ASSERT_GE(run.slots.back(), 0) << "and ends with one";
    const int* first = &particles[run.slots[0] * arity];
    std::vector<int> members;
    int gap = 0;
    for (int slot = 0; slot < static_cast<int>(run.slots.size()); ++slot) {
      const int c = run.slots[slot];
      if (c < 0) {
        EXPECT_LT(++gap, kLongestGap);
        continue;
      }
      gap = 0;
      members.push_back(c);
      ++seen[c];
      for (int j = 0; j < arity; ++j) {
        EXPECT_EQ(particles[c * arity + j], first[j] + slot);
        EXPECT_EQ(class_of[particles[c * arity + j]], class_of[first[j]]);
      }
    }
    held += static_cast<int>(members.size());
    EXPECT_GE(static_cast<int>(members.size()), kShortest);
    EXPECT_TRUE(independent(members, particles, arity, movable));
  }
  for (const int c : found.loose) ++seen[c];
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), count) << "each constraint once";
  EXPECT_TRUE(std::is_sorted(found.loose.begin(), found.loose.end()));
  EXPECT_EQ(found.contiguous(), held);
}

/// Classes of `size` particles each.
std::vector<std::uint8_t> blocks(int classes, int size) {
  std::vector<std::uint8_t> class_of;
  for (int k = 0; k < classes; ++k) class_of.insert(class_of.end(), size, static_cast<std::uint8_t>(k));
  return class_of;
}

/// Constraints (i, 100 + i) for the given i.
std::vector<int> rungs(const std::vector<int>& list) {
  std::vector<int> particles;
  for (const int i : list) particles.insert(particles.end(), {i, 100 + i});
  return particles;
}
std::vector<int> numbers(int from, int to) {
  std::vector<int> list(to - from);
  std::iota(list.begin(), list.end(), from);
  return list;
}

TEST(FindRuns, MakesOneRunOfALadder) {
  const auto particles = rungs(numbers(3, 53));
  const Runs found = find_runs(particles, 2, blocks(2, 100));
  expect_sound(found, particles, 2, blocks(2, 100));
  ASSERT_EQ(found.runs.size(), 1u);
  EXPECT_EQ(found.runs[0].slots, numbers(0, 50));
  EXPECT_TRUE(found.loose.empty());
}

TEST(FindRuns, DoesNotDependOnTheOrderOfTheLadder) {
  Random random(1);
  auto list = numbers(3, 53);
  for (int i = 49; i > 0; --i) std::swap(list[i], list[random.below(i + 1)]);
  const auto particles = rungs(list);
  const Runs found = find_runs(particles, 2, blocks(2, 100));
  expect_sound(found, particles, 2, blocks(2, 100));
  ASSERT_EQ(found.runs.size(), 1u);
  EXPECT_EQ(found.contiguous(), 50);
}

TEST(FindRuns, MakesTwoRunsOfAChainWhosePlacesAlternate) {
  // Particle n of the chain is number n / 2 of class n % 2: even edges are (k, 100 + k), odd ones (100 + k, k + 1).
  std::vector<int> particles;
  for (int n = 0; n < 80; ++n)
    particles.insert(particles.end(), {n / 2 + n % 2 * 100, (n + 1) / 2 + (n + 1) % 2 * 100});
  const Runs found = find_runs(particles, 2, blocks(2, 100));
  expect_sound(found, particles, 2, blocks(2, 100));
  EXPECT_EQ(found.runs.size(), 2u);
  EXPECT_EQ(found.contiguous(), 80);
}

TEST(FindRuns, BridgesShortGapsAndNoLongOnes) {
  for (const int missing : {1, kLongestGap - 1, kLongestGap, 20}) {
    auto list = numbers(0, 10);
    for (const int i : numbers(10 + missing, 30 + missing)) list.push_back(i);
    const auto particles = rungs(list);
    const Runs found = find_runs(particles, 2, blocks(2, 100));
    expect_sound(found, particles, 2, blocks(2, 100));
    EXPECT_EQ(found.contiguous(), 30);
    if (missing < kLongestGap) {
      ASSERT_EQ(found.runs.size(), 1u) << missing;
      EXPECT_EQ(static_cast<int>(found.runs[0].slots.size()), 30 + missing);
      EXPECT_EQ(std::count(found.runs[0].slots.begin(), found.runs[0].slots.end(), -1), missing);
    } else {
      EXPECT_EQ(found.runs.size(), 2u) << missing;
    }
  }
}

TEST(FindRuns, LeavesWhatIsTooShortLoose) {
  for (const int length : {1, kShortest - 1, kShortest}) {
    const auto particles = rungs(numbers(0, length));
    const Runs found = find_runs(particles, 2, blocks(2, 100));
    expect_sound(found, particles, 2, blocks(2, 100));
    EXPECT_EQ(found.contiguous(), length < kShortest ? 0 : length);
  }
}

TEST(FindRuns, KeepsToOneClassAtEachEnd) {
  // All particles advance by one, but 0 .. 19 are of one class and 20 .. 39 of another.
  const std::vector<std::uint8_t> class_of = blocks(10, 20);
  const auto particles = rungs(numbers(0, 40));
  const Runs found = find_runs(particles, 2, class_of);
  expect_sound(found, particles, 2, class_of);
  EXPECT_EQ(found.runs.size(), 2u);
}

TEST(FindRuns, GivesEachOfTwoEqualConstraintsASlot) {
  auto list = numbers(0, 20);
  list.insert(list.begin() + 10, 10);  // 10 occurs twice
  auto particles = rungs(list);
  Runs found = find_runs(particles, 2, blocks(2, 100));
  expect_sound(found, particles, 2, blocks(2, 100));
  EXPECT_EQ(found.runs.size(), 2u);
  for (const int i : numbers(0, 20)) list.push_back(i);  // all constraints occur again
  particles = rungs(list);
  expect_sound(find_runs(particles, 2, blocks(2, 100)), particles, 2, blocks(2, 100));
}

TEST(FindRuns, HoldsEachConstraintOnceInIndependentRunsOnTangles) {
  Random random(2);
  int held = 0;
  for (const int arity : {1, 2, 3, 4})
    for (const int constraints : {1, 30, 300, 2000})
      for (int trial = 0; trial < 5; ++trial) {
        // Ladders with random shifts in classes of their own, with loose constraints among them.
        const auto class_of = blocks(6, 60);
        std::vector<int> particles;
        int shift[kMostParticles] = {};
        for (int c = 0; c < constraints; ++c) {
          if (c % 25 == 0)
            for (int j = 0; j < arity; ++j) shift[j] = (j + trial) % 6 * 60 + random.below(30);
          const bool loose = random.below(4) == 0;
          for (int j = 0; j < arity; ++j)
            particles.push_back(loose ? (j + 1) % 6 * 60 + random.below(60) : shift[j] + c % 25);
        }
        const Runs found = find_runs(particles, arity, class_of);
        expect_sound(found, particles, arity, class_of);
        held += found.contiguous();
      }
  EXPECT_GT(held, 1000) << "there was something to find";
}

TEST(FindRuns, OfNothingIsEmpty) {
  const Runs found = find_runs({}, 2, {});
  EXPECT_TRUE(found.runs.empty());
  EXPECT_TRUE(found.loose.empty());
  EXPECT_EQ(found.contiguous(), 0);
}

}  // namespace
}  // namespace malha
