// SPDX-License-Identifier: Apache-2.0
// The adaptive thread count on a simulated machine with times of its own.
#include "host/base/adaptive_thread_count.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/numbers.h"

namespace malha {
namespace {

/// The time of a step on all threads and on one, and the part of it for which the thread has a core.
struct Machine {
  double alone, together, share = 1;
};

struct Spent {
  double all = 0, alone = 0;  // s
  int steps = 0;
};

/// Runs steps for `seconds`; the time of each varies by up to `noise` of it.
Spent work(AdaptiveThreadCount& choice, const Machine& machine, double seconds, double noise, Random& random) {
  Spent spent;
  while (spent.all < seconds) {
    const bool together = choice.threads() > 1;
    const double wall = (together ? machine.together : machine.alone) * (1 + noise * random());
    choice.took(wall, wall * machine.share);
    spent.all += wall, spent.alone += together ? 0 : wall, ++spent.steps;
  }
  return spent;
}

/// Runs steps of 0.2 to 200 ms.
template <class Check>
void for_each_step_length(const Check& check) {
  Random random(1);
  for (const double step : {2e-4, 2e-3, 0.02, 0.2}) {
    SCOPED_TRACE(step);
    check(step, random);
  }
}

TEST(AdaptiveThreadCount, OnAQuietMachineAllThreadsWork) {
  for_each_step_length([](double step, Random& random) {
    AdaptiveThreadCount choice(2);
    work(choice, {step, step / 1.6}, std::max(0.25, 5 * step), 0.1, random);  // the first steps
    const Spent spent = work(choice, {step, step / 1.6}, 300 * std::max(step, 0.05), 0.1, random);
    EXPECT_EQ(spent.alone, 0);
  });
}

/// Trials may cost a twentieth; as much again is for noise and for the first trial.
TEST(AdaptiveThreadCount, WhereATeamIsSlowStepsTakeATenthMoreThanOnOneThread) {
  for (const double slower : {1.05, 1.5, 3.0, 19.0})
    for (const double share : {1.0, 0.5})
      for_each_step_length([&](double step, Random& random) {
        AdaptiveThreadCount choice(2);
        const Machine busy{step, step * slower, share};
        const Spent spent = work(choice, busy, 1000 * std::max(step, 0.05), 0.02, random);
        EXPECT_LT(spent.all / spent.steps, 1.1 * step) << slower << " times slower, a share of " << share;
      });
}

TEST(AdaptiveThreadCount, AllWorkAgainSoonAfterOtherProgramsHaveEnded) {
  for_each_step_length([](double step, Random& random) {
    AdaptiveThreadCount choice(2);
    work(choice, {step, step * 19, 0.5}, 1000 * std::max(step, 0.05), 0.1, random);
    const Machine quiet{step, step / 1.6, 1};
    work(choice, quiet, 3 * std::max(step, 0.05), 0.1, random);
    EXPECT_EQ(work(choice, quiet, 100 * std::max(step, 0.05), 0.1, random).alone, 0);
  });
}

TEST(AdaptiveThreadCount, OneWorksSoonAfterOtherProgramsHaveCome) {
  for_each_step_length([](double step, Random& random) {
    AdaptiveThreadCount choice(2);
    work(choice, {step, step / 1.6}, 100 * std::max(step, 0.05), 0.1, random);
    const Machine busy{step, step * 5, 0.5};
    work(choice, busy, 3 * std::max(5 * step, 0.05), 0.1, random);
    const Spent spent = work(choice, busy, 20 * std::max(step, 0.05), 0.1, random);
    EXPECT_GT(spent.alone, 0.85 * spent.all) << "but for a trial";
  });
}

/// A cloth that falls through the air until it folds.
TEST(AdaptiveThreadCount, AllWorkSoonAfterStepsHaveMoreToDo) {
  for_each_step_length([](double step, Random& random) {
    AdaptiveThreadCount choice(2);
    work(choice, {step, step * 1.2}, 1000 * std::max(step, 0.05), 0.1, random);
    const Machine heavier{4 * step, 4 * step / 1.6};
    work(choice, heavier, 4 * std::max(4 * step, 0.05), 0.1, random);
    EXPECT_EQ(work(choice, heavier, 20 * std::max(4 * step, 0.05), 0.1, random).alone, 0);
  });
}

TEST(AdaptiveThreadCount, OfOneThreadIsOne) {
  AdaptiveThreadCount choice(1);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(choice.threads(), 1);
    choice.took(1, 0.1);
  }
}

/// The time that a thread ran is measured however busy the machine is: it passes only while the thread has a core.
TEST(AdaptiveThreadCount, TellsAThreadThatComputesFromOneThatHasNoCore) {
  const AdaptiveThreadCount::Took sleeping =
      AdaptiveThreadCount::time_of([] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
  EXPECT_GE(sleeping.wall, 0.02);
  EXPECT_LT(sleeping.running, 0.01);
  double done = 0;
  const AdaptiveThreadCount::Took computing = AdaptiveThreadCount::time_of([&] {
    volatile double sum = 0;
    while (done < 0.02)
      done += thread_seconds([&] {
        for (int i = 0; i < 100'000; ++i) sum = sum + i;
      });
  });
  EXPECT_GE(computing.running, done);
  EXPECT_GE(computing.wall, 0.9 * computing.running);  // the two times come from different clocks
}

TEST(AdaptiveThreadCount, LimitsWhatAStepLaunchesEvenIfItThrows) {
  AdaptiveThreadCount choice(8);
  choice.take([] { EXPECT_EQ(max_threads, 1); });
  EXPECT_THROW(choice.take([] { throw 1; }), int);
  EXPECT_EQ(max_threads, kAllThreads);
}

}  // namespace
}  // namespace malha
