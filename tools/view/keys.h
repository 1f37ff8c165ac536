// SPDX-License-Identifier: Apache-2.0
// Queue of input events between GLFW, which reports each at once, and Dear ImGui, which polls the keys once a frame.
#pragma once
#include <algorithm>
#include <deque>
#include <vector>

namespace malha::view {

/// An event of the keyboard or a mouse button.
struct Input {
  enum class Kind { Key, Modifier, Letter, Button };
  Kind kind = Kind::Key;
  int code = 0;                            // GLFW's key or button, or the Unicode of a letter
  int action = 0, held = 0, scancode = 0;  // GLFW's action, modifier bits and scancode
  bool presses = false, repeats = false;
};

/// Passes the events in order, to each frame only as many as it can distinguish. Otherwise a key that goes down and up
/// within one frame would be lost, and Ctrl would be up before its letter is polled.
class InputQueue {
 public:
  void add(const Input& input) { pending_.push_back(input); }
  bool has_pending() const { return !pending_.empty(); }

  std::vector<Input> of_next_frame() {
    std::vector<Input> now;
    bool pressed = false;
    const auto must_wait = [&](const Input& next) {
      if (next.kind == Input::Kind::Letter || next.repeats) return false;
      const auto same = [&](const Input& one) { return one.kind == next.kind && one.code == next.code; };
      return pressed || (next.kind != Input::Kind::Modifier && std::ranges::any_of(now, same));
    };
    while (has_pending() && !must_wait(pending_.front())) {
      now.push_back(pending_.front());
      pending_.pop_front();
      pressed = pressed || (now.back().presses && now.back().kind != Input::Kind::Modifier);
    }
    return now;
  }

 private:
  std::deque<Input> pending_;
};

}  // namespace malha::view
