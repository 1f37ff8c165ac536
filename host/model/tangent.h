// SPDX-License-Identifier: Apache-2.0
// Ways along a curved surface, as if it were unrolled near a particle: flat ones are exact, and so are cylinders'.
#pragma once
#include "kernels/simd/vec.h"
#include "malha/mesh.h"

namespace malha {

using Vector = Vector3<double>;

inline Vector vector(const Vec3& a) { return {a[0], a[1], a[2]}; }

/// `way` laid into the plane of `normal` (0: all of space), at `length`.
inline Vector along(const Vector& way, const Vector& normal, double length) {
  const Vector flat = way - normal * dot(way, normal);
  const double size = norm(flat), whole = norm(way);
  if (size > 1e-6 * whole) return flat * (length / size);
  return whole > 0 ? way * (length / whole) : Vector{0, 0, 0};  // across the surface: some way or other
}

/// a turned as the shortest turn takes the normal `from` to `to`.
inline Vector turned(const Vector& a, const Vector& from, const Vector& to) {
  const double c = 1 + dot(from, to);
  if (!(c > 1e-6)) return -a;  // half a turn, about some axis
  const Vector axis = cross(from, to), once = cross(axis, a);
  return a + once + cross(axis, once) * (1 / c);
}

}  // namespace malha
