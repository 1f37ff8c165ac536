// SPDX-License-Identifier: Apache-2.0
// A rigid motion from a frame of its own to the world. In double: far from the origin a turn has few digits to lose.
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

/// world = r local + t; r is a rotation, row by row.
struct Pose {
  double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vector3<double> t{0, 0, 0};  // m
  bool moves = false;          // otherwise it is the identity
};

KERNEL Vector3<double> rotate(const Pose& a, const Vector3<double>& v) {
  if (!a.moves) return v;
  return {a.r[0] * v.x + a.r[1] * v.y + a.r[2] * v.z, a.r[3] * v.x + a.r[4] * v.y + a.r[5] * v.z,
          a.r[6] * v.x + a.r[7] * v.y + a.r[8] * v.z};
}
KERNEL Vector3<double> to_world(const Pose& a, const Vector3<double>& v) { return a.moves ? rotate(a, v) + a.t : v; }
KERNEL Vector3<double> to_local(const Pose& a, const Vector3<double>& world) {
  if (!a.moves) return world;
  const Vector3<double> v = world - a.t;
  return {a.r[0] * v.x + a.r[3] * v.y + a.r[6] * v.z, a.r[1] * v.x + a.r[4] * v.y + a.r[7] * v.z,
          a.r[2] * v.x + a.r[5] * v.y + a.r[8] * v.z};
}

/// What moves rigidly and takes particles along, by number.
using Carrier = int;
inline constexpr Carrier kNobody = -1;

/// Which of them has each particle, and where each goes in a substep: from the world to the world.
struct Carriers {
  Carrier* of = nullptr;  // none: nobody has any
  const Pose* motion = nullptr;
};

}  // namespace malha
