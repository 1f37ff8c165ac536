// SPDX-License-Identifier: Apache-2.0
// Exceptions of malha. A message is one line that names the file, the place, what was found and what is allowed.
#pragma once
#include <stdexcept>
#include <string>

#include "malha/text.h"

namespace malha {

/// Thrown for input that is not valid, before anything is written (exit status 2 of the command). The message is one
/// line that a terminal can show, whatever bytes the files and their names contain.
struct InputError : std::runtime_error {
  explicit InputError(const std::string& message) : std::runtime_error(printable(message)) {}
};

/// Thrown for input that needs more memory than is free (exit status 5). The message says how much of either.
struct OutOfMemory : InputError {
  using InputError::InputError;
};

/// Thrown when a run becomes non-finite or explodes (exit status 3). The message says at which step and where.
struct Diverged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Thrown when a device no longer responds (exit status 4).
struct DeviceLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws an Error with the message "FILE: PLACE: found FOUND; allowed: ALLOWED".
/// `place` is "line 3", "line 3, column 7", "byte 120" or a JSON pointer such as "/bodies/0/mass"; it may be empty.
template <class Error = InputError>
[[noreturn]] void refuse(const std::string& file, const std::string& place, const std::string& found,
                         const std::string& allowed) {
  throw Error(file + ": " + (place.empty() ? "" : place + ": ") + "found " + found + "; allowed: " + allowed);
}

}  // namespace malha
