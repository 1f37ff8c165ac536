// How far a run is: a bar that redraws itself on a terminal, a plain line every tenth otherwise.
#pragma once
#include "host/run.h"

namespace malha {

class ProgressReporter {
 public:
  /// `quiet` says nothing at all. Lines go to standard error, so that standard output stays for results.
  explicit ProgressReporter(bool quiet);
  void operator()(const Progress& progress);

 private:
  void draw_bar(const Progress& progress);

  bool quiet_, terminal_;
  double seconds_ = 0;    // of steps so far
  double drawn_at_ = -1;  // seconds_ when the bar was last drawn
  std::int64_t tenth_ = 0;
};

}  // namespace malha
