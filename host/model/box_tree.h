// SPDX-License-Identifier: Apache-2.0
// Boxes in a tree, for questions at set-up: near-linear whatever the sizes of the boxes.
#pragma once
#include <cstdint>
#include <vector>

#include "host/mesh/bounding_box.h"

namespace malha {

bool overlap(const BoundingBox& a, const BoundingBox& b);

/// Of the points x[i] with i among `corners`, wider by `margin`.
template <class Corners>
BoundingBox bounds_of(const std::vector<Vec3>& x, const Corners& corners, double margin) {
  BoundingBox box = bounds_of(x, corners);
  for (int k = 0; k < 3; ++k) box.low[k] -= margin, box.high[k] += margin;
  return box;
}

class BoxTree {
 public:
  explicit BoxTree(std::vector<BoundingBox> boxes);

  /// Calls visit(i) for every box i that the segment from a to b touches, up to rounding, in no order to rely on.
  template <class Visit>
  void for_each_on(const Vec3& a, const Vec3& b, const Visit& visit) const {
    const Segment segment = segment_of(a, b);
    walk([&](const BoundingBox& box) { return touches(box, segment); }, visit);
  }

  /// How many boxes overlap this one.
  std::int64_t count_overlaps(const BoundingBox& box) const;

 private:
  struct Node {
    BoundingBox bounds;
    int begin, end;  // of order_
    int second;      // its second child; the first comes right after it; 0: a leaf
  };

  int build(int begin, int end);

  /// What is asked of many boxes.
  struct Segment {
    Vec3 from, per;  // m; 1/m along each axis, 0 where it hardly goes
    BoundingBox around;
    double slack;  // m
  };
  Segment segment_of(const Vec3& a, const Vec3& b) const;
  static bool touches(const BoundingBox& box, const Segment& segment);

  template <class Touches, class Visit>
  void walk(const Touches& touches_it, const Visit& visit) const {
    if (nodes_.empty()) return;
    int waiting[64], count = 0;  // halves: no deeper than the bits of an int
    waiting[count++] = 0;
    while (count > 0) {
      const int n = waiting[--count];
      const Node& node = nodes_[n];
      if (!touches_it(node.bounds)) continue;
      if (node.second > 0) {
        waiting[count++] = node.second, waiting[count++] = n + 1;
        continue;
      }
      for (int k = node.begin; k < node.end; ++k)
        if (touches_it(boxes_[order_[k]])) visit(order_[k]);
    }
  }

  std::vector<BoundingBox> boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
  double largest_ = 0;  // of their coordinates
};

}  // namespace malha
