// SPDX-License-Identifier: Apache-2.0
#include "tools/tune/progress_line.h"

#include <unistd.h>

#include <cstdio>

namespace malha::tuning {

void ProgressLine::operator()(const std::string& what, double part) {
  status_.show(what, part);
  const auto now = Clock::now();
  if (isatty(STDERR_FILENO) || std::chrono::duration<double>(now - said_at_).count() < silence_) return;
  std::fprintf(stderr, "%s\n", what.c_str());
  said_at_ = now;
}

}  // namespace malha::tuning
