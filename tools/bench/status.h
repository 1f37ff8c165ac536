// SPDX-License-Identifier: Apache-2.0
// What the benchmark is doing: one line that redraws itself on a terminal, and nothing elsewhere.
#pragma once
#include <string>

namespace malha::bench {

/// Writes to standard error, so that standard output stays for results.
class Status {
 public:
  Status();
  ~Status() { clear(); }
  Status(const Status&) = delete;
  Status& operator=(const Status&) = delete;

  /// `part` of everything is done: 0 to 1.
  void show(const std::string& what, double part);
  void clear();  // before lines of the results

 private:
  bool terminal_, shown_ = false;
};

}  // namespace malha::bench
