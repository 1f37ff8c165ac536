// SPDX-License-Identifier: Apache-2.0
// Sides of faces, sorted so that the sides of each edge are adjacent.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "host/mesh/compressed_lists.h"
#include "malha/mesh.h"

namespace malha {

/// A side of a face. `number` is its index in the order in which faces (and lines) list their sides; `forward` means
/// that it runs from the lower point to the higher one.
struct Side {
  int low, high;
  int number;
  bool forward;
};

inline bool same_edge(const Side& a, const Side& b) { return a.low == b.low && a.high == b.high; }

/// All sides, sorted by (low, high, number), so that the sides of an edge are adjacent. `visit(add)` must call
/// add(from, to) for every side in order; it is called twice. A side from a point to itself is numbered but left out.
/// It takes linear time for meshes, and n log n where one point has most of the sides.
template <class Visit>
std::vector<Side> sorted_sides(std::size_t points, Visit visit) {
  CompressedLists<Side> by_low(points, [&](const auto& add) {
    int number = 0;
    visit([&](int from, int to) {
      if (from != to) add(std::min(from, to), Side{std::min(from, to), std::max(from, to), number, from < to});
      ++number;
    });
  });
  for (std::size_t i = 0; i < points; ++i)
    std::ranges::sort(by_low[static_cast<int>(i)], [](const Side& a, const Side& b) {
      return a.high != b.high ? a.high < b.high : a.number < b.number;
    });
  return std::move(by_low.list);
}

/// Calls group(first, last) for the sides of each edge.
template <class Group>
void for_each_edge(const std::vector<Side>& sides, Group group) {
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last = std::find_if(first, sides.end(), [&](const Side& side) { return !same_edge(side, *first); });
    group(first, last);
    first = last;
  }
}

/// Calls add(from, to) for every side of every face.
template <class Add>
void for_each_face_side(const std::vector<Quad>& faces, Add add) {
  for (const Quad& face : faces) {
    const int corners = is_triangle(face) ? 3 : 4;
    for (int k = 0; k < corners; ++k) add(face[k], face[k + 1 < corners ? k + 1 : 0]);
  }
}

}  // namespace malha
