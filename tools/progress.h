// How far a run is: a bar that redraws itself on a terminal, plain lines otherwise.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "host/results/run.h"

namespace malha {

/// Writes to standard error, so that standard output stays for results.
class ProgressReporter {
 public:
  /// `quiet` says nothing but warnings.
  explicit ProgressReporter(bool quiet);
  /// Leaves the bar's line.
  ~ProgressReporter();
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  /// Of a long set-up. On a terminal 20 times a second, otherwise every 5 s.
  void setup(const char* what, double part);
  /// "SCENE: warning: LINE", in the bar's place.
  void warn(const std::string& scene, const std::string& line);
  /// On a terminal 20 times a second, otherwise every tenth of the run and every 10 s; and at the end.
  void operator()(const Progress& progress);

 private:
  using Clock = std::chrono::steady_clock;
  void draw_bar(double part, const std::string& line);

  bool quiet_, terminal_, drawn_ = false;
  Clock::time_point start_, said_at_;  // of the first step that was seen; of the last line
  Clock::time_point setup_said_at_ = Clock::now();
  std::int64_t first_ = -1, tenth_ = 0;  // step at start_; tenths of the run that were said
  std::int64_t steps_since_ = 0;         // that was said
  double ms_since_ = 0;
};

}  // namespace malha
