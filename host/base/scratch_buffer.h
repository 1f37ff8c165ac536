// SPDX-License-Identifier: Apache-2.0
// Memory that kernels work on and whose need changes from step to step.
#pragma once
#include "host/base/array.h"

namespace malha {

/// At least as many T as were last asked for; it grows by an eighth more and never shrinks. What it held is lost when
/// it grows.
template <class Executor, class T>
class ScratchBuffer {
 public:
  T* at_least(std::size_t count) {
    if (count > items_.size()) {
      items_ = {};
      items_ = Array<Executor, T>(count + count / 8, T{});
    }
    return items_.data();
  }
  T* data() const { return items_.data(); }
  std::size_t bytes() const { return items_.bytes(); }

 private:
  Array<Executor, T> items_;
};

}  // namespace malha
