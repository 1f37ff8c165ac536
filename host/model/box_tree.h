// SPDX-License-Identifier: Apache-2.0
// A tree of axis-aligned boxes for queries at set-up. Queries take nearly linear time in all, for boxes of any sizes.
#pragma once
#include <cstdint>
#include <vector>

#include "host/mesh/bounding_box.h"

namespace malha {

/// True if the boxes overlap or touch.
bool overlap(const BoundingBox& a, const BoundingBox& b);

/// The bounding box of the points x[i] with i among `corners`, extended by `margin` (m) on all sides.
template <class Corners>
BoundingBox bounds_of(const std::vector<Vec3>& x, const Corners& corners, double margin) {
  BoundingBox box = bounds_of(x, corners);
  for (int k = 0; k < 3; ++k) box.low[k] -= margin, box.high[k] += margin;
  return box;
}

class BoxTree {
 public:
  explicit BoxTree(std::vector<BoundingBox> boxes);

  /// Calls visit(i) for every box i that the segment from a to b touches, up to rounding, in an unspecified order.
  template <class Visit>
  void for_each_on_segment(const Vec3& a, const Vec3& b, const Visit& visit) const {
    const Segment segment = segment_of(a, b);
    traverse([&](const BoundingBox& box) { return touches(box, segment); }, visit);
  }

  /// Number of boxes that overlap this one.
  std::int64_t count_overlaps(const BoundingBox& box) const;

 private:
  struct Node {
    BoundingBox bounds;
    int begin, end;  // range of order_
    int second;      // second child, 0: a leaf; the first child follows the node
  };

  int build(int begin, int end);

  /// A segment prepared for tests against many boxes.
  struct Segment {
    Vec3 from, per;      // m; 1 / extent along each axis, 0 along axes without extent
    BoundingBox bounds;  // of the segment, extended by slack
    double slack;        // m, tolerance for rounding
  };
  Segment segment_of(const Vec3& a, const Vec3& b) const;
  static bool touches(const BoundingBox& box, const Segment& segment);

  template <class Touches, class Visit>
  void traverse(const Touches& touches_it, const Visit& visit) const {
    if (nodes_.empty()) return;
    int stack[64], count = 0;  // nodes are halved, so that the tree is no deeper than the bits of an int
    stack[count++] = 0;
    while (count > 0) {
      const int n = stack[--count];
      const Node& node = nodes_[n];
      if (!touches_it(node.bounds)) continue;
      if (node.second > 0) {
        stack[count++] = node.second, stack[count++] = n + 1;
        continue;
      }
      for (int k = node.begin; k < node.end; ++k)
        if (touches_it(boxes_[order_[k]])) visit(order_[k]);
    }
  }

  std::vector<BoundingBox> boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
  double largest_ = 0;  // largest coordinate of the boxes, m
};

}  // namespace malha
