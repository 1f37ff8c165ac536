// SPDX-License-Identifier: Apache-2.0
// Handling of Ctrl-C while C++ computes: Python records the signal, and code that holds the interpreter must poll it.
#pragma once
#include <pybind11/pybind11.h>

#include <chrono>

namespace malha::python {

class SignalPolling {
 public:
  /// Returns whether polling is due. Polling needs the interpreter, which another thread may hold.
  bool is_due() const { return std::chrono::steady_clock::now() - polled_ > std::chrono::milliseconds(20); }
  /// Polls the signals; the caller holds the interpreter. Throws the exception of the signal's handler:
  /// KeyboardInterrupt.
  void poll() {
    polled_ = std::chrono::steady_clock::now();
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }

 private:
  std::chrono::steady_clock::time_point polled_ = std::chrono::steady_clock::now();
};

}  // namespace malha::python
