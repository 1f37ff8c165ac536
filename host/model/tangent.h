// SPDX-License-Identifier: Apache-2.0
// Tangent vectors and parallel transport on a curved surface that is unrolled near a particle. They are exact on planes
// and cylinders.
#pragma once
#include "kernels/simd/vec.h"
#include "malha/mesh.h"

namespace malha {

using Vector = Vector3<double>;

/// A Vec3 as Vector.
inline Vector vector(const Vec3& a) { return {a[0], a[1], a[2]}; }

/// The direction of `offset` in the plane of `normal` (0: in space), scaled to `length`.
inline Vector tangent_vector(const Vector& offset, const Vector& normal, double length) {
  const Vector flat = offset - normal * dot(offset, normal);
  const double size = norm(flat), whole = norm(offset);
  if (size > 1e-6 * whole) return flat * (length / size);
  return whole > 0 ? offset * (length / whole) : Vector{0, 0, 0};  // parallel to the normal: any direction
}

/// The vector a after the smallest rotation that takes the normal `from` to `to`.
inline Vector parallel_transport(const Vector& a, const Vector& from, const Vector& to) {
  const double c = 1 + dot(from, to);
  if (!(c > 1e-6)) return -a;  // half a turn, about any axis
  const Vector axis = cross(from, to), once = cross(axis, a);
  return a + once + cross(axis, once) * (1 / c);
}

}  // namespace malha
