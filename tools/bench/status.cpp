// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/status.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace malha::bench {

Status::Status() : terminal_(isatty(STDERR_FILENO) != 0) {}

void Status::show(const std::string& what, double part) {
  if (!terminal_) return;
  constexpr std::size_t width = 30;
  const auto filled = std::min(width, static_cast<std::size_t>(part * width));
  const std::string line = "[" + std::string(filled, '#') + std::string(width - filled, '.') + "] " + what;
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  // One column stays free: a full line would wrap, and the next one could not redraw it.
  std::fprintf(stderr, "\r%s\033[K", line.substr(0, known ? size.ws_col - 1u : 79u).c_str());
  std::fflush(stderr);
  shown_ = true;
}

void Status::clear() {
  if (shown_) std::fprintf(stderr, "\r\033[K");
  shown_ = false;
}

}  // namespace malha::bench
