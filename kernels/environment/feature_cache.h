// SPDX-License-Identifier: Apache-2.0
// Cache of the closest feature (face, edge or corner) of a mesh to a particle. Within a validity radius it stays the
// closest, and no triangle has to be tested: the closest point on a feature is a projection.
#pragma once
#include "kernels/environment/triangle_octree.h"

namespace malha {

/// The rule of all entries of a proximity cache (proximity_cache.h): an entry that was made at `at` holds for a
/// particle at p while that has moved less than `radius`. A negative radius never holds.
KERNEL bool holds(const Vector3<double>& p, const Vector3<double>& at, double radius) {
  const Vector3<double> moved = p - at;
  return radius > 0 && dot(moved, moved) < radius * radius;
}

/// A closest feature; positions are relative to the mesh's centre, m.
struct ClosestFeature {
  Vector3<double> at{};  // it is the closest feature of the mesh to every point within `radius` of this one
  double radius = -1;    // m; below 0: not known
  Vector3<double> o{};   // a corner of the feature, or the point itself
  Vector3<double> d{};   // unit: direction of an edge, normal of a face
  Vector3<double> normal{};
  int triangle = -1;
  enum Kind : signed char { Corner, Edge, Face, Point } kind = Point;  // Point: valid for one position alone
  bool boundary = false;

  KERNEL bool is_valid_at(const Vector3<double>& p) const { return holds(p, at, radius); }

  /// Closest point on the feature to p, if it is the closest feature to p.
  KERNEL Vector3<double> nearest(const Vector3<double>& p) const {
    const double along = dot(p - o, d);
    return kind == Face ? p - d * along : kind == Edge ? o + d * along : o;
  }
};

/// Radius within which the closest feature of a point stays the closest, bounded by every candidate triangle.
class FeatureValidityRadius {
 public:
  /// `error`: upper bound of the error of computed distances, m.
  KERNEL FeatureValidityRadius(const OctreeView& mesh, const Vector3<double>& p, const ClosestTriangle& near,
                               double error)
      : mesh_(mesh), p_(p), near_(near), error_(error), corners_(mesh.triangles[near.triangle]) {}

  /// Radius (m) within which triangle t is no nearer than the feature, and, if t contains the feature, the closest
  /// point of t stays on it. `q`, `d2`: the closest point of t, and its squared distance. May be `enough` if it is
  /// larger than that.
  KERNEL double radius_for(int t, const Vector3<double>& q, double d2, double enough) const {
    const double far = near_.distance + 4 * error_ + 2 * enough;
    if (d2 > far * far) return enough;
    const int* c = mesh_.triangles[t];
    if (near_.where.corner >= 0) {
      const int v = corners_[near_.where.corner];
      for (int k = 0; k < 3; ++k)
        if (c[k] == v) return of_corner(v, c[(k + 1) % 3], c[(k + 2) % 3]) - error_;
    } else if (near_.where.edge >= 0) {
      const int a = corners_[near_.where.edge], b = corners_[(near_.where.edge + 1) % 3];
      for (int k = 0; k < 3; ++k) {
        const int from = c[k], to = c[(k + 1) % 3];
        if ((from == a && to == b) || (from == b && to == a)) return of_edge(from, to, c[(k + 2) % 3]) - error_;
      }
    } else if (t == near_.triangle) {
      return of_face() - error_;
    }
    return of_other(q, sqrt(d2));
  }

 private:
  KERNEL Vector3<double> corner(int v) const { return mesh_.corners[v].xyz(); }
  KERNEL static double least(double a, double b) { return a < b ? a : b; }

  /// Within it both edges at corner v lead away from the point.
  KERNEL double of_corner(int v, int b, int c) const {
    const Vector3<double> to_b = corner(b) - corner(v), to_c = corner(c) - corner(v), p = p_ - corner(v);
    return least(-dot(p, to_b) / norm(to_b), -dot(p, to_c) / norm(to_c));
  }

  /// Within it the point projects onto the edge, and lies on the other side of it than the triangle's third corner.
  KERNEL double of_edge(int a, int b, int c) const {
    const Vector3<double> way = corner(b) - corner(a), p = p_ - corner(a);
    const double l = norm(way);
    const Vector3<double> along = way * (1 / l), to_c = corner(c) - corner(a);
    const Vector3<double> inwards = to_c - along * dot(to_c, along);
    const double from_a = dot(p, along);
    return least(least(from_a, l - from_a), -dot(p, inwards) / norm(inwards));
  }

  /// Within it the point projects onto the face.
  KERNEL double of_face() const {
    double margin = INFINITY;
    for (int k = 0; k < 3; ++k) {
      const Vector3<double> a = corner(corners_[k]), way = corner(corners_[(k + 1) % 3]) - a;
      margin = least(margin, norm(cross(way, near_.where.q - a)) / norm(way));
    }
    return margin;
  }

  /// Let n be the directions from the closest points. After a displacement w the distance from t, a convex set, has
  /// grown by at least n_t w, and that from the feature by at most n w + w^2 / (2 distance), without the square for a
  /// face. In any case the difference shrinks by at most 2 metres per metre.
  KERNEL double of_other(const Vector3<double>& q, double distance) const {
    const double d = near_.distance, gap = distance - d - 4 * error_;
    if (!(gap > 0)) return -1;
    // A computed distance that is too long by an error e may belong to a point that is off by sqrt(2 d e).
    const double off = 2 * (error_ + sqrt(2 * distance * error_));
    const double turn = norm((p_ - q) * (1 / distance) - (p_ - near_.where.q) * (1 / d)) + off / d;
    const bool face = near_.where.corner < 0 && near_.where.edge < 0;
    const double r = face ? least(gap / turn, d) : d * (sqrt(turn * turn + 2 * gap / d) - turn);
    return r > gap / 2 ? r : gap / 2;
  }

  const OctreeView& mesh_;
  Vector3<double> p_;
  const ClosestTriangle& near_;
  double error_;
  const int* corners_;
};

}  // namespace malha
