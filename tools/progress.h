// SPDX-License-Identifier: Apache-2.0
// Progress of a run: a status line that is redrawn on a terminal, plain lines otherwise.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "host/run/run.h"

namespace malha {

/// Writes progress to standard error; standard output is for results.
class ProgressReporter {
 public:
  /// `quiet`: only warnings are written.
  explicit ProgressReporter(bool quiet);
  /// Leaves the line of the last step, and clears one of the set-up.
  ~ProgressReporter();
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  /// Reports the progress of set-up: on a terminal 20 times a second and whenever an activity begins (part < 0),
  /// otherwise every 5 s.
  void setup(const char* what, double part);
  /// Writes "SCENE: warning: LINE" in place of the bar.
  void warn(const std::string& scene, const std::string& line);
  /// Reports a step: on a terminal 20 times a second, otherwise every tenth of the run and every 10 s; and the last
  /// one.
  void operator()(const Progress& progress);
  /// Shows an activity other than a step when it begins, on a terminal in place of the speed.
  void show_activity(const char* what);

 private:
  using Clock = std::chrono::steady_clock;
  void draw_bar(double part, const std::string& line);

  bool quiet_, terminal_, drawn_ = false;
  Clock::time_point start_, reported_at_;  // time of the first reported step; of the last line
  Clock::time_point setup_reported_at_ = Clock::now();
  std::int64_t first_ = -1, tenth_ = 0;  // step at start_; tenths of the run that were reported
  std::int64_t steps_since_ = 0;         // steps since the last line
  double ms_since_ = 0;
  Progress last_{};                 // the last step
  std::string line_;                // the line of the last reported step
  const char* activity_ = nullptr;  // the activity that is shown
};

}  // namespace malha
