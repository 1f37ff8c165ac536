// SPDX-License-Identifier: Apache-2.0
// How far a run is: one line that redraws itself on a terminal, plain lines otherwise.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "host/run/run.h"

namespace malha {

/// Writes to standard error, so that standard output stays for results.
class ProgressReporter {
 public:
  /// `quiet` says nothing but warnings.
  explicit ProgressReporter(bool quiet);
  /// Leaves the line of the last step that was seen; clears one of the set-up.
  ~ProgressReporter();
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  /// Of a set-up. On a terminal 20 times a second and whenever something begins (part < 0), otherwise every 5 s.
  void setup(const char* what, double part);
  /// "SCENE: warning: LINE", in the bar's place.
  void warn(const std::string& scene, const std::string& line);
  /// On a terminal 20 times a second, otherwise every tenth of the run and every 10 s; and at the end.
  void operator()(const Progress& progress);
  /// What is begun that is not a step: on a terminal, in place of its speed.
  void doing(const char* what);

 private:
  using Clock = std::chrono::steady_clock;
  void draw_bar(double part, const std::string& line);

  bool quiet_, terminal_, drawn_ = false;
  Clock::time_point start_, said_at_;  // of the first step that was seen; of the last line
  Clock::time_point setup_said_at_ = Clock::now();
  std::int64_t first_ = -1, tenth_ = 0;  // step at start_; tenths of the run that were said
  std::int64_t steps_since_ = 0;         // that was said
  double ms_since_ = 0;
  Progress last_{};              // that was seen
  std::string line_;             // of the last step that was said
  const char* doing_ = nullptr;  // beside it
};

}  // namespace malha
