// SPDX-License-Identifier: Apache-2.0
// The end of the interpreter while other threads compute: they come back to it before it goes, or it would take them
// down in the midst of C++, which ends the process.
#pragma once
#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace malha::python {

class Leaving {
 public:
  /// While it lives the interpreter waits with its end. Made and dropped by who holds it.
  class Inside {
   public:
    Inside() { ++inside(); }
    ~Inside() { --inside(); }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;
  };

  /// Whether this thread is to come back.
  static bool now() { return leaving() && std::this_thread::get_id() != last(); }
  /// Ends this thread, as threading takes it, if it is to come back. Holding the interpreter.
  static void ask() {
    if (!now()) return;
    PyErr_SetNone(PyExc_SystemExit);
    throw pybind11::error_already_set();
  }
  /// Python's last thread waits for the others.
  static void wait() {
    last() = std::this_thread::get_id(), leaving() = true;
    const pybind11::gil_scoped_release release;
    while (inside() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  static std::atomic<int>& inside() {
    static std::atomic<int> count{0};
    return count;
  }
  static std::atomic<bool>& leaving() {
    static std::atomic<bool> flag{false};
    return flag;
  }
  static std::thread::id& last() {
    static std::thread::id id;
    return id;
  }
};

}  // namespace malha::python
