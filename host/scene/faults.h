// SPDX-License-Identifier: Apache-2.0
// Several faults of one input, told at once.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "malha/error.h"

namespace malha {

/// Several faults, a line each; every line names its file, place, what was found and what is allowed.
struct InputErrors : InputError {
  explicit InputErrors(std::string lines) : InputError(lines), lines_(printable_lines(lines)) {}
  const char* what() const noexcept override { return lines_.c_str(); }

 private:
  std::string lines_;
};

/// Collects the faults of an input where reading can go on behind a fault.
class Faults {
 public:
  /// Notes the fault that `read` refuses. A lack of memory is thrown on.
  template <class Read>
  void collect(const Read& read) {
    try {
      read();
    } catch (const OutOfMemory&) {
      throw;
    } catch (const Noted&) {
    } catch (const InputError& fault) {
      if (++count_ <= kMost) lines_ += (count_ > 1 ? "\n" : "") + std::string(fault.what());
    }
  }
  std::size_t count() const { return count_; }
  /// Ends the reading of a part whose faults are all noted.
  [[noreturn]] static void end_part() { throw Noted(); }
  /// Throws the faults, if there are any.
  void throw_all() const {
    if (count_ == 1) throw InputError(lines_);
    if (count_ > kMost) throw InputErrors(lines_ + "\n... and " + std::to_string(count_ - kMost) + " more");
    if (count_ > 0) throw InputErrors(lines_);
  }

 private:
  struct Noted : InputError {
    Noted() : InputError("a part with faults that are noted") {}
  };
  static constexpr std::size_t kMost = 20;
  std::string lines_;
  std::size_t count_ = 0;
};

}  // namespace malha
