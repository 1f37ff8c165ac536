// SPDX-License-Identifier: Apache-2.0
// Adaptive number of threads of a step: all, or one where other programs use the cores.
#pragma once
#include "host/base/scoped_value.h"
#include "host/base/stopwatch.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// A team waits for its slowest thread: where other programs take its cores in turns, it can be many times slower than
/// one thread alone. The choice is by trials, and trials of the slower one take about a
/// twentieth of all time. Results do not depend on it, because partitions do not.
class ThreadChoice {
 public:
  /// Starts with one.
  explicit ThreadChoice(int threads) : all_(threads) {}

  /// For the next step.
  int threads() const { return together_ ? all_ : 1; }

  /// Takes a step on threads().
  template <class Step>
  void take(const Step& step) {
    const ScopedValue<int> limit(max_threads, threads());
    const Took time = time_of(step);
    took(time.wall, time.running);
  }

  /// Seconds that a step takes, and for how many of them its calling thread has a core.
  struct Took {
    double wall, running;
  };
  template <class Step>
  static Took time_of(const Step& step) {
    double running = 0;
    const double wall = seconds([&] { running = thread_seconds(step); });
    return {wall, running};
  }

  /// A step has been taken on threads(): `wall` seconds, of which its calling thread had a core for `running`.
  void took(double wall, double running);

 private:
  static constexpr double kWindow = 0.05;  // s: some turns of a scheduler, or a step
  static constexpr double kRarely = 20;    // times what a trial costs until the next one
  static constexpr double kLongest = 10;   // s, between trials that are of no use
  static constexpr double kWorst = 20;     // times slower than one thread that a team may be
  static constexpr double kCrowded = 0.8;  // of the wall time: a thread that ran for less shared its core
  static constexpr double kSlower = 1.5;   // times its usual time: reason enough to try one thread
  static constexpr double kHeavier = 1.5;  // times what a step took when all lost: reason enough to try all again

  void observe_team(double step, double spent, bool crowded);
  void observe_single(double step, double spent, bool crowded);
  void decide(bool together, double wait);
  void try_the_other() { together_ = !together_, trial_ = true; }

  int all_;
  bool together_ = false, trial_ = false;
  int steps_ = 0;                                // of this window
  double wall_ = 0, running_ = 0;                // s, of this window
  double since_ = 0, wait_ = 3 * kWindow;        // s, since the last decision, and how long to keep to it
  double single_ = 0, usual_ = 0;                // s, a step on one thread and on all, when last seen
  double lost_at_ = 0;                           // s, a step on one thread when all lost
  bool known_ = false;                           // whether all were tried
  bool crowded_ = false, lost_crowded_ = false;  // whether others used the one thread's core: now, and when all lost
};

}  // namespace malha
