// SPDX-License-Identifier: Apache-2.0
// Where things are in the window.
#pragma once
#include <algorithm>

#include "tools/view/camera.h"

namespace malha::view {

/// Of the panels, pixels, on a display that shows everything so many times larger.
struct Panels {
  explicit Panels(float times = 1)
      : left(int(250 * times)), right(int(330 * times)), timeline(int(62 * times)), scale(times) {}
  int left, right, timeline;
  float scale;
};

/// Of one of so many sides, in a window of this size. `shown`: the panels are.
inline Viewport port_of(int side, int sides, bool shown, int width, int height, const Panels& panels = Panels()) {
  const int left = shown ? panels.left : 0, right = shown ? panels.right : 0;
  const int room = std::max(width - left - right, sides);
  return {left + side * room / sides, 0, room / sides, std::max(height - panels.timeline, 1)};
}

}  // namespace malha::view
