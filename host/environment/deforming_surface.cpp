// SPDX-License-Identifier: Apache-2.0
#include "host/environment/deforming_surface.h"

#include <algorithm>
#include <numeric>

#include "host/mesh/bisection.h"
#include "host/mesh/edge_sides.h"

namespace malha {

namespace {

std::vector<Triangle> in_tree_order(const Mesh& mesh) {
  const std::vector<Triangle> all = triangles(mesh);
  std::vector<Vec3> centroid;
  for (const auto& [a, b, c] : all) {
    Vec3 sum;
    for (int k = 0; k < 3; ++k) sum[k] = (mesh.points[a][k] + mesh.points[b][k] + mesh.points[c][k]) / 3;
    centroid.push_back(sum);
  }
  std::vector<int> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  bisect(centroid, order, kBranch, [](int count) {
    int block = kBranch;  // whole blocks of the tree
    while (block * kBranch < count) block *= kBranch;
    return block;
  });
  std::vector<Triangle> ordered;
  for (const int t : order) ordered.push_back(all[t]);
  return ordered;
}

}  // namespace

DeformingSurface deforming_surface(const Mesh& mesh) {
  DeformingSurface surface;
  surface.triangles = in_tree_order(mesh);
  const std::vector<Triangle>& all = surface.triangles;
  for (const Triangle& t : all)
    for (int k = 0; k < 3; ++k) surface.corner[k].push_back(kIndexScale<double> * t[k]);
  surface.star = {mesh.points.size(), [&](const auto& add) {
                    for (std::size_t t = 0; t < all.size(); ++t)
                      for (const int v : all[t]) add(v, static_cast<int>(t));
                  }};
  for (std::vector<int>& neighbour : surface.neighbour) neighbour.assign(all.size(), -1);
  surface.rim.assign(mesh.points.size(), 0);
  const auto visit = [&](const auto& add) {
    for (const auto& [a, b, c] : all) add(a, b), add(b, c), add(c, a);
  };
  for_each_edge(sorted_sides(mesh.points.size(), visit), [&](auto first, auto last) {
    const auto forward = std::count_if(first, last, [](const Side& side) { return side.forward; });
    if (forward == 0 || forward == last - first) surface.rim[first->low] = surface.rim[first->high] = 1;
    if (forward != 1 || last - first != 2) return;
    const int one = first[0].number, other = first[1].number;
    surface.neighbour[one % 3][one / 3] = other / 3, surface.neighbour[other % 3][other / 3] = one / 3;
  });
  return surface;
}

}  // namespace malha
