// SPDX-License-Identifier: Apache-2.0
// Layout of the window.
#pragma once
#include <algorithm>

#include "tools/view/camera.h"

namespace malha::view {

/// Sizes of the panels in pixels on a display with this scale factor.
struct Panels {
  explicit Panels(float times = 1)
      : left(int(250 * times)), right(int(330 * times)), timeline(int(62 * times)), scale(times) {}
  int left, right, timeline;
  float scale;
};

/// Returns the viewport of one of `sides` sides in a window of this size. `shown`: the panels are visible.
inline Viewport port_of(int side, int sides, bool shown, int width, int height, const Panels& panels = Panels()) {
  const int left = shown ? panels.left : 0, right = shown ? panels.right : 0;
  const int room = std::max(width - left - right, sides);
  return {left + side * room / sides, 0, room / sides, std::max(height - panels.timeline, 1)};
}

}  // namespace malha::view
