// SPDX-License-Identifier: Apache-2.0
// Ctrl-C while C++ computes: Python notes the signal, and who holds the interpreter must ask for it.
#pragma once
#include <pybind11/pybind11.h>

#include <chrono>

namespace malha::python {

class Interrupts {
 public:
  /// Whether it is time to ask: that takes the interpreter, for which another thread may let us wait.
  bool due() const { return std::chrono::steady_clock::now() - asked_ > std::chrono::milliseconds(20); }
  /// Holding the interpreter. Throws what the signal's handler raised: KeyboardInterrupt.
  void ask() {
    asked_ = std::chrono::steady_clock::now();
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }

 private:
  std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
};

}  // namespace malha::python
