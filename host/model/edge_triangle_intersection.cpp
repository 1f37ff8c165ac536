// SPDX-License-Identifier: Apache-2.0
#include "host/model/edge_triangle_intersection.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/mesh/vectors.h"

namespace malha {

namespace {

/// Sign of the volume that b - a, c - a and d - a span; 0 if it is within rounding of 0.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = minus(b, a), v = minus(c, a), w = minus(d, a);
  double volume = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    volume += u[k] * (v[l] * w[m] - v[m] * w[l]);
    size += std::abs(u[k]) * (std::abs(v[l] * w[m]) + std::abs(v[m] * w[l]));
  }
  const double rounding = 1e-15 * size;
  return volume > rounding ? 1 : volume < -rounding ? -1 : 0;
}

/// Positive if three signs are equal, negative if two of them are opposite, otherwise 0.
int agreement(int a, int b, int c) {
  const auto [least, most] = std::minmax({a, b, c});
  return least * most;
}

/// Where the line through p and q passes the triangle: positive inside, 0 on the boundary, negative outside.
int passes(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  return agreement(orientation(p, q, a, b), orientation(p, q, b, c), orientation(p, q, c, a));
}

/// Tests in a plane.
struct InPlane {
  using Point = std::array<double, 2>;

  /// Sign of the area that b - a and c - a span; 0 if it is within rounding of 0.
  static int orientation(const Point& a, const Point& b, const Point& c) {
    const double left = (b[0] - a[0]) * (c[1] - a[1]), right = (b[1] - a[1]) * (c[0] - a[0]);
    const double rounding = 1e-15 * (std::abs(left) + std::abs(right));
    return left - right > rounding ? 1 : left - right < -rounding ? -1 : 0;
  }
  static bool boxes_meet(const Point& p, const Point& q, const Point& a, const Point& b) {
    for (int k = 0; k < 2; ++k)
      if (std::max(p[k], q[k]) < std::min(a[k], b[k]) || std::max(a[k], b[k]) < std::min(p[k], q[k])) return false;
    return true;
  }
  static bool segments_meet(const Point& p, const Point& q, const Point& a, const Point& b) {
    return orientation(p, q, a) * orientation(p, q, b) <= 0 && orientation(a, b, p) * orientation(a, b, q) <= 0 &&
           boxes_meet(p, q, a, b);
  }
  static bool in_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
    return agreement(orientation(a, b, p), orientation(b, c, p), orientation(c, a, p)) >= 0;
  }
};

/// Touching of a segment with a triangle in whose plane it lies.
bool touches_in_plane(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = normal(a, b, c);
  int along = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(n[k]) > std::abs(n[along])) along = k;
  if (n[along] == 0) return false;
  const auto flat = [along](const Vec3& x) { return InPlane::Point{x[(along + 1) % 3], x[(along + 2) % 3]}; };
  const InPlane::Point corner[] = {flat(a), flat(b), flat(c)}, from = flat(p), to = flat(q);
  if (InPlane::in_triangle(from, corner[0], corner[1], corner[2])) return true;
  for (int k = 0; k < 3; ++k)
    if (InPlane::segments_meet(from, to, corner[k], corner[(k + 1) % 3])) return true;
  return false;
}

}  // namespace

bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  return orientation(a, b, c, p) * orientation(a, b, c, q) < 0 && passes(p, q, a, b, c) > 0;
}

bool touches(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int start = orientation(a, b, c, p), end = orientation(a, b, c, q);
  if (start * end > 0) return false;
  if (start == 0 || end == 0) return touches_in_plane(start == 0 ? p : q, end == 0 ? q : p, a, b, c);
  return passes(p, q, a, b, c) >= 0;
}

}  // namespace malha
