#include "host/model/box_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace malha {

namespace {

constexpr int kLeaf = 8;

bool holds(const BoundingBox& a, const BoundingBox& b) {
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
  if (!order_.empty()) build(0, static_cast<int>(order_.size()));
}

/// Halves by the middles of the boxes, along the direction in which these spread most.
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
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (middles.high[k] - middles.low[k] > middles.high[axis] - middles.low[axis]) axis = k;
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

/// By the parts of the segment that lie between each pair of the box's planes. A little too many rather than one too
/// few: a plane's part is taken 1e-12 longer than rounding leaves it.
bool BoxTree::touches(const BoundingBox& box, const Vec3& a, const Vec3& b) {
  double from = 0, to = 1;
  for (int k = 0; k < 3; ++k) {
    const double along = b[k] - a[k];
    const double slack = 1e-12 * (std::abs(a[k]) + std::abs(b[k]) + std::abs(box.low[k]) + std::abs(box.high[k]));
    const double low = box.low[k] - slack - a[k], high = box.high[k] + slack - a[k];
    if (along == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double first = low / along, second = high / along;
    from = std::max(from, std::min(first, second)), to = std::min(to, std::max(first, second));
    if (from > to) return false;
  }
  return true;
}

std::int64_t BoxTree::count_overlaps(const BoundingBox& box) const {
  std::int64_t count = 0;
  if (nodes_.empty()) return 0;
  int waiting[64], left = 0;
  waiting[left++] = 0;
  while (left > 0) {
    const int n = waiting[--left];
    const Node& node = nodes_[n];
    if (!overlap(node.bounds, box)) continue;
    if (holds(box, node.bounds)) {
      count += node.end - node.begin;
    } else if (node.second > 0) {
      waiting[left++] = node.second, waiting[left++] = n + 1;
    } else {
      for (int k = node.begin; k < node.end; ++k) count += overlap(boxes_[order_[k]], box) ? 1 : 0;
    }
  }
  return count;
}

}  // namespace malha
