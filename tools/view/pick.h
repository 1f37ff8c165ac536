// SPDX-License-Identifier: Apache-2.0
// Which particle lies under the cursor, and what a camera that shows all is to hold.
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

/// The particles of all sides, and of the environment what is not much larger than they are; of larger objects, such as
/// a ground, the place of their box that is nearest to the particles.
std::vector<Place> places_of_all(const std::vector<std::shared_ptr<const Frame>>& sides);

}  // namespace malha::view
