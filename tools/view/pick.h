// SPDX-License-Identifier: Apache-2.0
// Picking of particles and edges on the screen, and the points for framing a scene.
#pragma once
#include <optional>

#include "tools/view/shown_state.h"

namespace malha::view {

/// Returns the corner nearest to a pixel of the front face under it; without a face, the nearest particle within
/// `reach` pixels; none if there is neither.
std::optional<int> pick(const Frame& frame, const OrbitCamera& camera, const Viewport& port, double x, double y,
                        double reach = 10);

/// Returns the edges that a stroke from one pixel to another crosses on the screen, hidden ones too, with the end on
/// its left first.
std::vector<Edge> edges_crossed(const Frame& frame, const OrbitCamera& camera, const Viewport& port,
                                const std::array<double, 2>& from, const std::array<double, 2>& to);

/// Returns the particles of all sides and the points of environment objects that are not much larger; of larger
/// objects, such as a ground, only the point of their bounding box nearest to the particles.
std::vector<Point3f> points_to_frame(const std::vector<std::shared_ptr<const Frame>>& sides);

}  // namespace malha::view
