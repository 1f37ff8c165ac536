// SPDX-License-Identifier: Apache-2.0
// Scratch memory whose required size changes from step to step.
#pragma once
#include "host/base/array.h"

namespace malha {

/// An array of at least the requested size. It starts with an eighth more, grows by half of it more and never shrinks;
/// growing discards its content.
template <class Executor, class T>
class ScratchBuffer {
 public:
  T* at_least(std::size_t count) {
    if (count > items_.size()) {
      const std::size_t more = count / (items_.size() > 0 ? 2 : 8);
      items_ = {};
      items_ = Array<Executor, T>(count + more, T{});
    }
    return items_.data();
  }
  T* data() const { return items_.data(); }
  std::size_t bytes() const { return items_.bytes(); }

 private:
  Array<Executor, T> items_;
};

}  // namespace malha
