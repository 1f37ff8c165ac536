// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/vertices.h"

#include <algorithm>

namespace malha {

std::vector<int> points_of_vertices(const FileVertices& file, int points) {
  std::vector<int> all = file.point;
  for (int i = all.empty() ? 0 : *std::ranges::max_element(all) + 1; i < points; ++i) all.push_back(i);
  return all;
}

int vertex_of(const FileVertices& file, int point) {
  if (file.point.empty()) return point;
  const std::vector<int> points = points_of_vertices(file, point + 1);
  return static_cast<int>(std::ranges::find(points, point) - points.begin());
}

}  // namespace malha
