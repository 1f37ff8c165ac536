// SPDX-License-Identifier: Apache-2.0
// Rigid transformation from a local frame to the world, in double: far from the origin a rotation loses many digits.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// world = r local + t; r is a rotation, row by row.
struct Pose {
  double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vector3<double> t{0, 0, 0};  // m
  bool moves = false;          // false: the identity
};

/// Vectors and points of numbers or of packs of double.
template <class S = double>
KERNEL Vector3<S> rotate(const Pose& a, const Vector3<S>& v) {
  if (!a.moves) return v;
  return {S(a.r[0]) * v.x + S(a.r[1]) * v.y + S(a.r[2]) * v.z, S(a.r[3]) * v.x + S(a.r[4]) * v.y + S(a.r[5]) * v.z,
          S(a.r[6]) * v.x + S(a.r[7]) * v.y + S(a.r[8]) * v.z};
}
template <class S = double>
KERNEL Vector3<S> to_world(const Pose& a, const Vector3<S>& v) {
  return a.moves ? rotate(a, v) + Vector3<S>{S(a.t.x), S(a.t.y), S(a.t.z)} : v;
}
template <class S = double>
KERNEL Vector3<S> to_local(const Pose& a, const Vector3<S>& world) {
  if (!a.moves) return world;
  const Vector3<S> v = world - Vector3<S>{S(a.t.x), S(a.t.y), S(a.t.z)};
  return {S(a.r[0]) * v.x + S(a.r[3]) * v.y + S(a.r[6]) * v.z, S(a.r[1]) * v.x + S(a.r[4]) * v.y + S(a.r[7]) * v.z,
          S(a.r[2]) * v.x + S(a.r[5]) * v.y + S(a.r[8]) * v.z};
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
