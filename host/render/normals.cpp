// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>

#include "host/render/stage.h"

namespace malha {

namespace {

constexpr float kCreaseCosine = 0.6f;  // 53 degrees: the edges of a box stay sharp, folds of coarse cloth are smooth

Vec at(const std::vector<std::array<float, 3>>& points, int i) { return Vec(points[i].data()); }

float angle_between(const Vec& a, const Vec& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

std::vector<Vec> corner_normals(const std::vector<std::array<float, 3>>& points,
                                const std::vector<Triangle>& triangles) {
  const auto count = triangles.size();
  std::vector<Vec> flat(count, Vec::Zero());
  std::vector<float> angles(3 * count, 0);
  std::vector<int> first(points.size() + 1,
                         0);  // the corners at point i are around[first[i]] .. around[first[i + 1] - 1]
  for (std::size_t t = 0; t < count; ++t) {
    const Vec a = at(points, triangles[t][0]), b = at(points, triangles[t][1]), c = at(points, triangles[t][2]);
    const Vec normal = (b - a).cross(c - a).stableNormalized();
    if (!normal.allFinite() || normal.isZero()) continue;
    flat[t] = normal;
    angles[3 * t] = angle_between(b - a, c - a);
    angles[3 * t + 1] = angle_between(c - b, a - b);
    angles[3 * t + 2] = angle_between(a - c, b - c);
    for (const int corner : triangles[t]) ++first[corner + 1];
  }
  for (std::size_t i = 0; i < points.size(); ++i) first[i + 1] += first[i];
  std::vector<int> around(first.back()), filled(first.begin(), first.end() - 1);
  for (std::size_t t = 0; t < count; ++t) {
    if (flat[t].isZero()) continue;
    for (int k = 0; k < 3; ++k) around[filled[triangles[t][k]]++] = static_cast<int>(3 * t) + k;
  }
  std::vector<Vec> normals(3 * count, Vec::Zero());
  for (std::size_t t = 0; t < count; ++t) {
    if (flat[t].isZero()) continue;
    for (int k = 0; k < 3; ++k) {
      const int point = triangles[t][k];
      Vec sum = Vec::Zero();
      for (int j = first[point]; j < first[point + 1]; ++j) {
        const Vec& other = flat[around[j] / 3];
        if (other.dot(flat[t]) >= kCreaseCosine) sum += angles[around[j]] * other;
      }
      normals[3 * t + k] = sum.normalized();
    }
  }
  return normals;
}

}  // namespace malha
