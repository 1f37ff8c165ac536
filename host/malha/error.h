// SPDX-License-Identifier: Apache-2.0
// What goes wrong and how it is said: one line that names the file, the place, what was found and what is allowed.
#pragma once
#include <stdexcept>
#include <string>

#include "malha/text.h"

namespace malha {

/// Input that was refused at the door (exit status 2 in the command). Thrown before anything is written. The message is
/// one line that a terminal can show, whatever bytes files and their names have.
struct InputError : std::runtime_error {
  explicit InputError(const std::string& message) : std::runtime_error(printable(message)) {}
};

/// Input that asks for more memory than there is (exit status 5): how much, and how much there is.
struct OutOfMemory : InputError {
  using InputError::InputError;
};

/// A run that became non-finite or exploded (exit status 3); the message says at which step and where.
struct Diverged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A device that no longer answers (exit status 4).
struct DeviceLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws InputError, or what is named, with the message "FILE: PLACE: found FOUND; allowed: ALLOWED".
/// `place` is "line 3", "line 3, column 7", "byte 120" or a JSON pointer such as "/bodies/0/mass"; it may be empty.
template <class Error = InputError>
[[noreturn]] void refuse(const std::string& file, const std::string& place, const std::string& found,
                         const std::string& allowed) {
  throw Error(file + ": " + (place.empty() ? "" : place + ": ") + "found " + found + "; allowed: " + allowed);
}

}  // namespace malha
