// SPDX-License-Identifier: Apache-2.0
// Shutdown of the interpreter while other threads compute. They return to the interpreter before it ends, because it
// would otherwise terminate them within C++, which ends the process.
#pragma once
#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace malha::python {

class Shutdown {
 public:
  /// While a guard lives, the interpreter does not end. It is made and destroyed while holding the interpreter.
  class Guard {
   public:
    Guard() { ++guards(); }
    ~Guard() { --guards(); }
    Guard(const Guard&) = delete;
    Guard& operator=(const Guard&) = delete;
  };

  /// Returns whether this thread must return to the interpreter.
  static bool is_pending() { return pending() && std::this_thread::get_id() != last_thread(); }
  /// Ends this thread by SystemExit if it must return; the caller holds the interpreter.
  static void exit_thread_if_pending() {
    if (!is_pending()) return;
    PyErr_SetNone(PyExc_SystemExit);
    throw pybind11::error_already_set();
  }
  /// Waits for the other threads; called by Python's last thread.
  static void wait_for_threads() {
    last_thread() = std::this_thread::get_id(), pending() = true;
    const pybind11::gil_scoped_release release;
    while (guards() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  static std::atomic<int>& guards() {
    static std::atomic<int> count{0};
    return count;
  }
  static std::atomic<bool>& pending() {
    static std::atomic<bool> flag{false};
    return flag;
  }
  static std::thread::id& last_thread() {
    static std::thread::id id;
    return id;
  }
};

}  // namespace malha::python
