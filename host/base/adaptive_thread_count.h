// SPDX-License-Identifier: Apache-2.0
// Adaptive number of threads of a step: all, or one where other programs use the cores.
#pragma once
#include "host/base/scoped_value.h"
#include "host/base/stopwatch.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// Chooses between all threads and one. A team waits for its slowest thread: where other programs use its cores, it can
/// be many times slower than one thread alone. The choice is by trials, and trials of the slower one take about a
/// twentieth of all time. Results do not depend on it, because partitions do not.
class AdaptiveThreadCount {
 public:
  /// The first step runs on one thread.
  explicit AdaptiveThreadCount(int threads) : all_(threads) {}

  /// Number of threads of the next step.
  int threads() const { return together_ ? all_ : 1; }

  /// Runs a step on threads(), and measures it.
  template <class Step>
  void take(const Step& step) {
    const ScopedValue<int> limit(max_threads, threads());
    const Took time = time_of(step);
    took(time.wall, time.running);
  }

  /// Wall time of a step, and CPU time of its calling thread, s.
  struct Took {
    double wall, running;
  };
  template <class Step>
  static Took time_of(const Step& step) {
    double running = 0;
    const double wall = seconds([&] { running = thread_seconds(step); });
    return {wall, running};
  }

  /// Records a step on threads(): its wall time and the CPU time of its calling thread, s.
  void took(double wall, double running);

 private:
  static constexpr double kWindow = 0.05;  // s, of a measurement: some time slices of a scheduler, at least one step
  static constexpr double kRarely = 20;    // pause until the next trial, over the cost of one
  static constexpr double kLongest = 10;   // s, longest pause between unsuccessful trials
  static constexpr double kWorst = 20;     // largest slow-down of a team, over one thread
  static constexpr double kCrowded = 0.8;  // a thread with less CPU time over wall time shared its core
  static constexpr double kSlower = 1.5;   // slow-down of a team that starts a trial of one thread
  static constexpr double kHeavier = 1.5;  // growth of a step since the team lost that starts a trial of it

  void observe_team(double step, double spent, bool crowded);
  void observe_single(double step, double spent, bool crowded);
  void decide(bool together, double wait);
  void try_the_other() { together_ = !together_, trial_ = true; }

  int all_;
  bool together_ = false, trial_ = false;
  int steps_ = 0;                          // of this window
  double wall_ = 0, running_ = 0;          // s, of this window
  double since_ = 0, wait_ = 3 * kWindow;  // s, time since the last decision, and until the next
  double single_ = 0, usual_ = 0;          // s, last time of a step on one thread and on all
  double lost_at_ = 0;                     // s, a step on one thread when the team lost
  bool known_ = false;                     // whether all threads have been tried
  bool crowded_ = false,
       lost_crowded_ = false;  // whether the single thread shared its core: now, and when the team lost
};

}  // namespace malha
