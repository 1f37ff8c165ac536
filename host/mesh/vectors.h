// SPDX-License-Identifier: Apache-2.0
// Arithmetic on Vec3 for set-up. Kernels have types of their own (kernels/simd/vec.h).
#pragma once
#include <cmath>

#include "malha/mesh.h"

namespace malha {

inline Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }
inline double squared_distance(const Vec3& a, const Vec3& b) { return dot(minus(a, b), minus(a, b)); }
/// The normal of a triangle, of twice its area.
inline Vec3 normal(const Vec3& a, const Vec3& b, const Vec3& c) { return cross(minus(b, a), minus(c, a)); }
/// The area of a triangle.
inline double area(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = normal(a, b, c);
  return std::hypot(n[0], n[1], n[2]) / 2;
}
inline bool finite(const Vec3& a) { return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]); }

}  // namespace malha
