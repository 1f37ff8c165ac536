// SPDX-License-Identifier: Apache-2.0
// Reference geometry of a triangle mesh by brute force: all triangles, in double, by other formulas than
// host/environment/closest_point_index.cpp.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "host/mesh/topology.h"
#include "tests/numbers.h"

namespace malha {

class BruteForce {
 public:
  using V = Vector3<double>;
  explicit BruteForce(const Mesh& mesh) : triangles_(triangles(mesh)) {
    for (const Vec3& x : mesh.points) points_.push_back({x[0], x[1], x[2]});
  }

  double distance(const V& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Triangle& t : triangles_)
      least = std::min(least, to_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2)));
    return least;
  }

  /// Winding number of a closed mesh around p: 1 inside, 0 outside (van Oosterom, Strackee 1983).
  double winding(const V& p) const {
    double sum = 0;
    for (const Triangle& t : triangles_) {
      const V a = corner(t, 0) - p, b = corner(t, 1) - p, c = corner(t, 2) - p;
      const double la = norm(a), lb = norm(b), lc = norm(c);
      sum += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return sum / (2 * std::numbers::pi);
  }

  /// The smallest t in [0, 1] at which a + t (b - a) lies on a triangle (only from its front if `front_only`); infinity
  /// for none. The result is not reliable on edges, between whose triangles the segment may slip through.
  double crossing(const V& a, const V& b, bool front_only) const {
    double first = std::numeric_limits<double>::infinity();
    for (const Triangle& t : triangles_) {
      const V o = corner(t, 0), u = corner(t, 1) - o, v = corner(t, 2) - o, n = cross(u, v), d = b - a;
      const double towards = dot(n, d);
      if (towards == 0 || (front_only && towards > 0)) continue;
      const double at = dot(n, o - a) / towards;
      const V r = a + d * at - o;
      const double n2 = dot(n, n), s = dot(cross(r, v), n) / n2, w = dot(cross(u, r), n) / n2;
      if (at >= 0 && at <= 1 && s >= 0 && w >= 0 && s + w <= 1) first = std::min(first, at);
    }
    return first;
  }

 private:
  const V& corner(const Triangle& t, int k) const { return points_[t[k]]; }

  static double to_segment(const V& p, const V& a, const V& b) {
    const V d = b - a;
    return norm(p - (a + d * std::clamp(dot(p - a, d) / dot(d, d), 0.0, 1.0)));
  }

  static double to_triangle(const V& p, const V& a, const V& b, const V& c) {
    const V n = cross(b - a, c - a);
    const bool above =
        dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 && dot(cross(a - c, p - c), n) >= 0;
    if (above) return std::abs(dot(p - a, n)) / norm(n);
    return std::min({to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)});
  }

  std::vector<V> points_;
  std::vector<Triangle> triangles_;
};

}  // namespace malha
