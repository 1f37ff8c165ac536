// Which particle lies under the cursor.
#pragma once
#include <optional>

#include "tools/view/shown_state.h"

namespace malha::view {

/// The corner nearest to a pixel of the front face under it; where there is no face, the nearest particle within
/// `reach` pixels. None: neither.
std::optional<int> pick(const Frame& frame, const OrbitCamera& camera, const Viewport& port, double x, double y,
                        double reach = 10);

/// The edges between particles that a stroke from one pixel to another crosses on the screen, whatever hides them:
/// first the end on its left.
std::vector<Edge> crossed(const Frame& frame, const OrbitCamera& camera, const Viewport& port,
                          const std::array<double, 2>& from, const std::array<double, 2>& to);

}  // namespace malha::view
