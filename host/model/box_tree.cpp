// SPDX-License-Identifier: Apache-2.0
#include "host/model/box_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace malha {

namespace {

constexpr int kLeaf = 8;  // largest number of boxes in a leaf

/// True if box a contains box b.
bool contains(const BoundingBox& a, const BoundingBox& b) {
  for (int k = 0; k < 3; ++k)
    if (a.low[k] > b.low[k] || b.high[k] > a.high[k]) return false;
  return true;
}

}  // namespace

bool overlap(const BoundingBox& a, const BoundingBox& b) {
  for (int k = 0; k < 3; ++k)
    if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
  return true;
}

BoxTree::BoxTree(std::vector<BoundingBox> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(boxes_.size() / 2 + 2);
  if (order_.empty()) return;
  build(0, static_cast<int>(order_.size()));
  const auto& [low, high] = nodes_[0].bounds;
  for (int k = 0; k < 3; ++k) largest_ = std::max({largest_, std::abs(low[k]), std::abs(high[k])});
}

/// Splits the boxes at the median of their centres, along the axis on which the centres spread most.
int BoxTree::build(int begin, int end) {
  const int n = static_cast<int>(nodes_.size());
  BoundingBox all = boxes_[order_[begin]], middles{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (int i = begin; i < end; ++i)
    for (int k = 0; k < 3; ++k) {
      const BoundingBox& box = boxes_[order_[i]];
      all.low[k] = std::min(all.low[k], box.low[k]), all.high[k] = std::max(all.high[k], box.high[k]);
      const double middle = box.low[k] + box.high[k];
      middles.low[k] = std::min(middles.low[k], middle), middles.high[k] = std::max(middles.high[k], middle);
    }
  nodes_.push_back({all, begin, end, 0});
  if (end - begin <= kLeaf) return n;
  const int axis = longest_side(middles);
  const int half = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end, [&](int i, int j) {
    const double a = boxes_[i].low[axis] + boxes_[i].high[axis], b = boxes_[j].low[axis] + boxes_[j].high[axis];
    return a != b ? a < b : i < j;
  });
  build(begin, half);
  const int second = build(half, end);
  nodes_[n].second = second;
  return n;
}

BoxTree::Segment BoxTree::segment_of(const Vec3& a, const Vec3& b) const {
  Segment segment{a, {}, {}, 0};
  double largest = largest_;
  for (int k = 0; k < 3; ++k) largest = std::max({largest, std::abs(a[k]), std::abs(b[k])});
  segment.slack = 4e-12 * largest;  // conservative: rather some boxes too many than one too few
  for (int k = 0; k < 3; ++k) {
    segment.bounds.low[k] = std::min(a[k], b[k]) - segment.slack;
    segment.bounds.high[k] = std::max(a[k], b[k]) + segment.slack;
    const double along = b[k] - a[k];
    segment.per[k] = std::abs(along) > segment.slack ? 1 / along : 0;
  }
  return segment;
}

/// Slab test: intersects the ranges of the segment between each pair of parallel planes of the box.
bool BoxTree::touches(const BoundingBox& box, const Segment& segment) {
  if (!overlap(box, segment.bounds)) return false;
  double from = 0, to = 1;
  for (int k = 0; k < 3; ++k) {
    if (segment.per[k] == 0) continue;
    const double first = (box.low[k] - segment.slack - segment.from[k]) * segment.per[k];
    const double second = (box.high[k] + segment.slack - segment.from[k]) * segment.per[k];
    from = std::max(from, std::min(first, second)), to = std::min(to, std::max(first, second));
  }
  return from <= to;
}

std::int64_t BoxTree::count_overlaps(const BoundingBox& box) const {
  std::int64_t count = 0;
  if (nodes_.empty()) return 0;
  int stack[64], left = 0;
  stack[left++] = 0;
  while (left > 0) {
    const int n = stack[--left];
    const Node& node = nodes_[n];
    if (!overlap(node.bounds, box)) continue;
    if (contains(box, node.bounds)) {
      count += node.end - node.begin;
    } else if (node.second > 0) {
      stack[left++] = node.second, stack[left++] = n + 1;
    } else {
      for (int k = node.begin; k < node.end; ++k) count += overlap(boxes_[order_[k]], box) ? 1 : 0;
    }
  }
  return count;
}

}  // namespace malha
