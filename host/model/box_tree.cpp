// SPDX-License-Identifier: Apache-2.0
#include "host/model/box_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace malha {

bool overlap(const BoundingBox& a, const BoundingBox& b) {
  for (int k = 0; k < 3; ++k)
    if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
  return true;
}

bool contains(const BoundingBox& a, const BoundingBox& b) {
  for (int k = 0; k < 3; ++k)
    if (a.low[k] > b.low[k] || b.high[k] > a.high[k]) return false;
  return true;
}

BoxTree::BoxTree(std::vector<BoundingBox> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(boxes_.size() / 2 + 2);
  if (!order_.empty()) build(0, static_cast<int>(order_.size()));
}

/// Splits the boxes at the median of their centres, along the axis on which the centres spread most.
int BoxTree::build(int begin, int end) {
  constexpr int kLeaf = 8;  // largest number of boxes in a leaf
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

}  // namespace malha
