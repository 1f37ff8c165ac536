// SPDX-License-Identifier: Apache-2.0
// Keys between GLFW, which tells of each at once, and Dear ImGui, which looks at what is down once a picture.
#pragma once
#include <algorithm>
#include <deque>
#include <vector>

namespace malha::view {

/// What a keyboard or a button of the mouse did.
struct Input {
  enum class Kind { Key, Modifier, Letter, Button };
  Kind kind = Kind::Key;
  int code = 0;                        // GLFW's key or button; of a letter its Unicode
  int action = 0, held = 0, scan = 0;  // GLFW's: pressed, let go of or repeated; Ctrl and the like; the key's place
  bool presses = false, repeats = false;
};

/// Gives every picture what it can tell apart, in order; the rest waits for the next ones. A key that goes down and up
/// within one picture would never have been down, and Ctrl would be up before its letter is seen.
class Keys {
 public:
  void add(const Input& input) { waiting_.push_back(input); }
  bool waits() const { return !waiting_.empty(); }

  std::vector<Input> of_a_picture() {
    std::vector<Input> now;
    bool pressed = false;
    const auto must_wait = [&](const Input& next) {
      if (next.kind == Input::Kind::Letter || next.repeats) return false;
      const auto same = [&](const Input& one) { return one.kind == next.kind && one.code == next.code; };
      return pressed || (next.kind != Input::Kind::Modifier && std::ranges::any_of(now, same));
    };
    while (waits() && !must_wait(waiting_.front())) {
      now.push_back(waiting_.front());
      waiting_.pop_front();
      pressed = pressed || (now.back().presses && now.back().kind != Input::Kind::Modifier);
    }
    return now;
  }

 private:
  std::deque<Input> waiting_;
};

}  // namespace malha::view
