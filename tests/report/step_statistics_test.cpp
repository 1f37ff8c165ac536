// SPDX-License-Identifier: Apache-2.0
// Step statistics: times of all steps, in memory that does not grow with their number.
#include "host/report/step_statistics.h"

#include <gtest/gtest.h>

namespace malha {
namespace {

TEST(StepStatistics, AreThoseOfAllStepsInMemoryThatDoesNotGrow) {
  StepStatistics times;
  EXPECT_EQ(times.median(), 0);
  const int steps = 1'000'000;
  std::size_t bytes_early = 0;
  for (int k = 0; k < steps; ++k) {
    times.add((k * 7919LL) % steps);  // each of 0 .. steps - 1 once
    if (k == 10'000) bytes_early = times.bytes();
  }
  EXPECT_EQ(times.bytes(), bytes_early);
  EXPECT_EQ(times.count(), steps);
  EXPECT_EQ(times.sum(), 0.5 * steps * (steps - 1.0));
  EXPECT_EQ(times.least(), 0);
  EXPECT_EQ(times.most(), steps - 1);
  EXPECT_EQ(times.last(), (steps - 1) * 7919LL % steps);
  // There are at least 2,048 samples: a random sample's median is off by 1.1 % of the range, once sigma.
  EXPECT_NEAR(times.median(), steps / 2, 0.05 * steps);
}

TEST(StepStatistics, OfFewStepsAreExact) {
  StepStatistics times;
  for (const double s : {3.0, 1.0, 2.0}) times.add(s);
  EXPECT_EQ(times.median(), 2);
  EXPECT_EQ(times.least(), 1);
  EXPECT_EQ(times.most(), 3);
}

}  // namespace
}  // namespace malha
