// SPDX-License-Identifier: Apache-2.0
// Order of points in which points that follow each other are close together.
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "host/mesh/bounding_box.h"

namespace malha {

/// Bisects the list of points recursively along the longest side of their bounding box, into parts of at most `most`
/// points, each sorted. The first half of a part with more is a multiple of block(its count).
template <class Block>
void bisect(const std::vector<Vec3>& x, std::span<int> list, int most, const Block& block) {
  const auto count = static_cast<int>(list.size());
  if (count <= most) return std::sort(list.begin(), list.end());
  const int axis = longest_side(bounds_of(x, list)), size = block(count);
  const auto middle = static_cast<std::size_t>((count / 2 + size - 1) / size * size);
  const auto before = [&](int a, int b) { return x[a][axis] != x[b][axis] ? x[a][axis] < x[b][axis] : a < b; };
  std::nth_element(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(middle), list.end(), before);
  bisect(x, list.first(middle), most, block);
  bisect(x, list.subspan(middle), most, block);
}

}  // namespace malha
