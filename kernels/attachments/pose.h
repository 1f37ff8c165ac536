// SPDX-License-Identifier: Apache-2.0
// Rigid transformation from a local frame to the world, in double: far from the origin a rotation loses many digits.
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

/// world = r local + t; r is a rotation, row by row.
struct Pose {
  double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vector3<double> t{0, 0, 0};  // m
  bool moves = false;          // false: the identity
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

/// Number of an object that moves rigidly and moves particles along with it.
using KinematicOwner = int;
inline constexpr KinematicOwner kNoOwner = -1;

/// Owner of every particle, and motion of every owner in a substep (world to world).
struct KinematicOwners {
  KinematicOwner* of = nullptr;  // null: no particle has an owner
  const Pose* motion = nullptr;
};

}  // namespace malha
