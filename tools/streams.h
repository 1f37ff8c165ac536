// SPDX-License-Identifier: Apache-2.0
// The standard streams of the programs.
#pragma once
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <iostream>
#include <stdexcept>

#include "tools/exit_status.h"

namespace malha {

/// Whoever reads our words may leave (malha run SCENE | head -1): the run goes on, and nobody hears it. A stream that
/// was closed before the start gets a place to write to: its number would be given to the next file that is opened.
inline void outlive_readers() {
  std::signal(SIGPIPE, SIG_IGN), std::signal(SIGXFSZ, SIG_IGN);  // too large a file fails as on a full disk
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDWR) != stream) std::_Exit(kFailed);
}

/// Throws where something was said on standard output that could not be written; a reader who left misses nothing.
inline void require_written() {
  pollfd state{STDOUT_FILENO, POLLOUT, 0};
  std::cout.flush();
  if (std::cout || (poll(&state, 1, 0) == 1 && (state.revents & POLLERR) != 0)) return;
  throw std::runtime_error("cannot write to standard output");
}

}  // namespace malha
