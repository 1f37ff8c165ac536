// SPDX-License-Identifier: Apache-2.0
// Progress of long work: a line that redraws itself on a terminal, and plain lines every few seconds elsewhere.
#pragma once
#include <chrono>
#include <string>

#include "tools/bench/status.h"

namespace malha::tuning {

class ProgressLine {
 public:
  /// `silence`: minimum time between plain lines, s.
  explicit ProgressLine(double silence) : silence_(silence) {}
  /// `part`: the finished part of the whole work, 0 to 1.
  void operator()(const std::string& what, double part);
  void clear() { status_.clear(); }  // before results are printed

 private:
  using Clock = std::chrono::steady_clock;
  double silence_;
  bench::Status status_;
  Clock::time_point said_at_ = Clock::now();
};

}  // namespace malha::tuning
