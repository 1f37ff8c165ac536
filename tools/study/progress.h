// How far a study is: a line that redraws itself on a terminal, plain lines every few seconds otherwise.
#pragma once
#include <chrono>
#include <string>

#include "tools/bench/status.h"

namespace malha::study {

class CellProgress {
 public:
  explicit CellProgress(const std::string& study) : study_(study) {}
  void operator()(const std::string& what, int done, int planned);
  void clear() { status_.clear(); }  // before results are printed

 private:
  using Clock = std::chrono::steady_clock;
  std::string study_;
  bench::Status status_;
  Clock::time_point said_at_ = Clock::now();
};

}  // namespace malha::study
