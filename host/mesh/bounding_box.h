// SPDX-License-Identifier: Apache-2.0
// Boxes along x, y and z around points.
#pragma once
#include <algorithm>
#include <vector>

#include "malha/mesh.h"

namespace malha {

struct BoundingBox {
  Vec3 low, high;  // m
};

inline void extend(BoundingBox& box, const Vec3& point) {
  for (int k = 0; k < 3; ++k)
    box.low[k] = std::min(box.low[k], point[k]), box.high[k] = std::max(box.high[k], point[k]);
}

/// Of the points x[i] with i among `which`: one or more.
template <class Which>
BoundingBox bounds_of(const std::vector<Vec3>& x, const Which& which) {
  BoundingBox box{x[*std::begin(which)], x[*std::begin(which)]};
  for (const int i : which) extend(box, x[i]);
  return box;
}
/// Of those from `begin` to `end`, one or more.
inline BoundingBox bounds_of_part(const std::vector<Vec3>& x, int begin, int end) {
  BoundingBox box{x[begin], x[begin]};
  for (int i = begin; i < end; ++i) extend(box, x[i]);
  return box;
}
/// Of all, one or more.
inline BoundingBox bounds_of(const std::vector<Vec3>& x) { return bounds_of_part(x, 0, static_cast<int>(x.size())); }

/// The direction in which it is longest, the first of several.
inline int longest_side(const BoundingBox& box) {
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (box.high[k] - box.low[k] > box.high[axis] - box.low[axis]) axis = k;
  return axis;
}

}  // namespace malha
