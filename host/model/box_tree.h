// SPDX-License-Identifier: Apache-2.0
// A tree of axis-aligned boxes for queries at set-up. Queries take nearly linear time in all, for boxes of any sizes.
#pragma once
#include <cstdint>
#include <vector>

#include "host/mesh/bounding_box.h"

namespace malha {

/// True if the boxes overlap or touch.
bool overlap(const BoundingBox& a, const BoundingBox& b);
/// True if box a contains box b.
bool contains(const BoundingBox& a, const BoundingBox& b);

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

  /// Calls visit(i) for every box i that overlaps this one, in an unspecified order.
  template <class Visit>
  void for_each_overlap(const BoundingBox& box, const Visit& visit) const {
    for_each_range(box, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) visit(order_[k]);
    });
  }

  /// Number of boxes that overlap this one.
  std::int64_t count_overlaps(const BoundingBox& box) const {
    std::int64_t count = 0;
    for_each_range(box, [&](int begin, int end) { count += end - begin; });
    return count;
  }

 private:
  struct Node {
    BoundingBox bounds;
    int begin, end;  // range of order_
    int second;      // second child, 0: a leaf; the first child follows the node
  };

  int build(int begin, int end);

  /// Calls visit(begin, end) for the ranges of order_ whose boxes overlap this one.
  template <class Visit>
  void for_each_range(const BoundingBox& box, const Visit& visit) const {
    if (nodes_.empty()) return;
    int stack[64], count = 0;  // nodes are halved, so that the tree is no deeper than the bits of an int
    stack[count++] = 0;
    while (count > 0) {
      const int n = stack[--count];
      const Node& node = nodes_[n];
      if (!overlap(node.bounds, box)) continue;
      if (contains(box, node.bounds)) {
        visit(node.begin, node.end);
      } else if (node.second > 0) {
        stack[count++] = node.second, stack[count++] = n + 1;
      } else {
        for (int k = node.begin; k < node.end; ++k)
          if (overlap(boxes_[order_[k]], box)) visit(k, k + 1);
      }
    }
  }

  std::vector<BoundingBox> boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace malha
