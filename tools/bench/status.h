// SPDX-License-Identifier: Apache-2.0
// Progress of a benchmark: one line that redraws itself on a terminal. Elsewhere nothing is shown.
#pragma once
#include <string>

namespace malha::bench {

/// Writes to standard error; standard output is for results.
class Status {
 public:
  Status();
  ~Status() { clear(); }
  Status(const Status&) = delete;
  Status& operator=(const Status&) = delete;

  /// `part`: the finished part of the whole benchmark, 0 to 1.
  void show(const std::string& what, double part);
  void clear();  // to be called before results are printed

 private:
  bool terminal_, shown_ = false;
};

}  // namespace malha::bench
