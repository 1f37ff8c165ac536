// SPDX-License-Identifier: Apache-2.0
// Axis-aligned bounding boxes of points.
#pragma once
#include <algorithm>
#include <vector>

#include "malha/mesh.h"

namespace malha {

struct BoundingBox {
  Vec3 low, high;  // m
};

/// Extends the box to contain the point.
inline void extend(BoundingBox& box, const Vec3& point) {
  for (int k = 0; k < 3; ++k)
    box.low[k] = std::min(box.low[k], point[k]), box.high[k] = std::max(box.high[k], point[k]);
}

/// The bounding box of the points x[i] with i among `which`, which must not be empty.
template <class Which>
BoundingBox bounds_of(const std::vector<Vec3>& x, const Which& which) {
  BoundingBox box{x[*std::begin(which)], x[*std::begin(which)]};
  for (const int i : which) extend(box, x[i]);
  return box;
}
/// The bounding box of all points, of which there must be one.
inline BoundingBox bounds_of(const std::vector<Vec3>& x) {
  BoundingBox box{x[0], x[0]};
  for (const Vec3& point : x) extend(box, point);
  return box;
}

/// The axis along which the box is longest; the first of several.
inline int longest_side(const BoundingBox& box) {
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (box.high[k] - box.low[k] > box.high[axis] - box.low[axis]) axis = k;
  return axis;
}

}  // namespace malha
