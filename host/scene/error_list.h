// SPDX-License-Identifier: Apache-2.0
// Collection of several errors of one input, which are reported together.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "malha/error.h"

namespace malha {

/// Several errors, one line each. Every line names the file, the place, what was found and what is allowed.
struct InputErrors : InputError {
  explicit InputErrors(std::string lines) : InputError(lines), lines_(printable_lines(lines)) {}
  const char* what() const noexcept override { return lines_.c_str(); }

 private:
  std::string lines_;
};

/// Collects the errors of an input that can be read further after an error.
class ErrorList {
 public:
  /// Calls read() and records the InputError that it throws. OutOfMemory is passed on.
  template <class Read>
  void collect(const Read& read) {
    try {
      read();
    } catch (const OutOfMemory&) {
      throw;
    } catch (const AlreadyRecorded&) {
    } catch (const InputError& error) {
      if (++count_ <= kMaxReported) lines_ += (count_ > 1 ? "\n" : "") + std::string(error.what());
    }
  }
  std::size_t count() const { return count_; }
  /// Ends the reading of a part all of whose errors are recorded.
  [[noreturn]] static void end_part() { throw AlreadyRecorded(); }
  /// Throws the errors, if there are any.
  void throw_all() const {
    if (count_ == 1) throw InputError(lines_);
    if (count_ > kMaxReported)
      throw InputErrors(lines_ + "\n... and " + std::to_string(count_ - kMaxReported) + " more");
    if (count_ > 0) throw InputErrors(lines_);
  }

 private:
  struct AlreadyRecorded : InputError {
    AlreadyRecorded() : InputError("a part with recorded errors") {}
  };
  static constexpr std::size_t kMaxReported = 20;
  std::string lines_;
  std::size_t count_ = 0;
};

}  // namespace malha
