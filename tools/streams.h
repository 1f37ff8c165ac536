// SPDX-License-Identifier: Apache-2.0
// Handling of the standard streams of the programs.
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

/// Ignores closed pipes, so that a run goes on after its reader has left (malha run SCENE | head -1). Opens /dev/null
/// in place of standard streams that were closed before the start, because the next opened file would get their
/// numbers.
inline void ignore_closed_streams() {
  std::signal(SIGPIPE, SIG_IGN), std::signal(SIGXFSZ, SIG_IGN);  // exceeding the file size limit fails like a full disk
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDWR) != stream) std::_Exit(kFailed);
}

/// Throws if standard output could not be written, unless its reader has left.
inline void require_written() {
  pollfd state{STDOUT_FILENO, POLLOUT, 0};
  std::cout.flush();
  if (std::cout || (poll(&state, 1, 0) == 1 && (state.revents & POLLERR) != 0)) return;
  throw std::runtime_error("cannot write to standard output");
}

}  // namespace malha
