// Where things are in the window.
#pragma once
#include <algorithm>

#include "tools/view/camera.h"

namespace malha::view {

inline constexpr int kLeftPanel = 250, kRightPanel = 330, kTimeline = 62;  // pixels

/// Of one of so many sides, in a window of this size.
inline Viewport port_of(int side, int sides, bool panels, int width, int height) {
  const int left = panels ? kLeftPanel : 0, right = panels ? kRightPanel : 0;
  const int room = std::max(width - left - right, sides);
  return {left + side * room / sides, 0, room / sides, std::max(height - kTimeline, 1)};
}

}  // namespace malha::view
