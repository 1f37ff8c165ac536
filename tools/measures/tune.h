// malha tune: what it takes from the command line, and where its results go.
#pragma once
#include <atomic>

#include "tools/arguments.h"

namespace malha {

/// Prints what was tried and writes the tuned scene; the exit status. Throws study::Interrupted where `stop` is set,
/// InputError, std::runtime_error (disk): nothing is written then.
int tune(const Arguments& arguments, const std::atomic<bool>& stop);

}  // namespace malha
