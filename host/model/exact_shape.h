// SPDX-License-Identifier: Apache-2.0
// Exact shapes of the environment as kernels need them, where their objects are at first, and meshes to draw them.
#pragma once
#include <vector>

#include "kernels/environment/shapes.h"
#include "malha/scene.h"

namespace malha {

/// An exact shape and its pose in the frame of its object: that of the world where the object has not moved yet.
struct PlacedShape {
  ConvexShape shape;
  Pose pose;
};

/// `shape` is exact, and the transform scales round shapes alike in all directions.
PlacedShape place(const Shape& shape, const Transform& transform);

/// A mesh of an exact shape, in the frame of its object, for drawing; that of a box is the box itself. A plane is drawn
/// as a square below the bodies, whose positions (m) are `bodies`.
Mesh drawing_of(const Shape& shape, const Transform& transform, const std::vector<Vec3>& bodies);

/// The pose that maps a point by `second`, and then by `first`.
Pose composed(const Pose& first, const Pose& second);

}  // namespace malha
