// SPDX-License-Identifier: Apache-2.0
#include "host/environment/deforming_surface.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <span>

#include "host/mesh/bounding_box.h"

namespace malha {

namespace {

/// Bisects the list recursively along the longest side of the box of its centroids, into whole blocks of the tree.
void bisect(const std::vector<Vec3>& centroid, std::span<int> list) {
  const auto count = static_cast<int>(list.size());
  if (count <= kBranch) return std::sort(list.begin(), list.end());
  const int axis = longest_side(bounds_of(centroid, list));
  int block = kBranch;
  while (block * kBranch < count) block *= kBranch;
  const int middle = (count / 2 + block - 1) / block * block;
  const auto before = [&](int a, int b) {
    return centroid[a][axis] != centroid[b][axis] ? centroid[a][axis] < centroid[b][axis] : a < b;
  };
  std::nth_element(list.begin(), list.begin() + middle, list.end(), before);
  bisect(centroid, list.first(static_cast<std::size_t>(middle)));
  bisect(centroid, list.subspan(static_cast<std::size_t>(middle)));
}

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
  bisect(centroid, order);
  std::vector<Triangle> ordered;
  for (const int t : order) ordered.push_back(all[t]);
  return ordered;
}

}  // namespace

DeformingSurface deforming_surface(const Mesh& mesh) {
  DeformingSurface surface;
  surface.triangles = in_tree_order(mesh);
  const int count = static_cast<int>(surface.triangles.size());
  std::map<std::pair<int, int>, std::vector<int>> sides;  // triangles that have the directed edge
  std::vector<std::vector<int>> stars(mesh.points.size());
  for (int t = 0; t < count; ++t)
    for (int k = 0; k < 3; ++k) {
      const Triangle& at = surface.triangles[t];
      sides[{at[k], at[(k + 1) % 3]}].push_back(t);
      stars[at[k]].push_back(t);
      surface.corner[k].push_back(kIndexScale<double> * at[k]);
    }
  surface.rim.assign(mesh.points.size(), 0);
  for (int t = 0; t < count; ++t)
    for (int k = 0; k < 3; ++k) {
      const int from = surface.triangles[t][k], to = surface.triangles[t][(k + 1) % 3];
      const auto across = sides.find({to, from});
      const bool one = sides[{from, to}].size() == 1 && across != sides.end() && across->second.size() == 1;
      surface.neighbour[k].push_back(one ? across->second[0] : -1);
      if (across == sides.end()) surface.rim[from] = surface.rim[to] = 1;
    }
  surface.star_begin = {0};
  for (const std::vector<int>& star : stars) {
    surface.star.insert(surface.star.end(), star.begin(), star.end());
    surface.star_begin.push_back(static_cast<int>(surface.star.size()));
  }
  return surface;
}

}  // namespace malha
