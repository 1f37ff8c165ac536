// Where a rigidly moving mesh is at a time.
#pragma once
#include <vector>

#include "host/scene.h"
#include "kernels/vec.h"

namespace malha {

/// world = r local + t; r is a rotation, row by row.
struct Pose {
  double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vector3<double> t{0, 0, 0};  // m
};

inline Vector3<double> rotate(const Pose& a, const Vector3<double>& v) {
  return {a.r[0] * v.x + a.r[1] * v.y + a.r[2] * v.z, a.r[3] * v.x + a.r[4] * v.y + a.r[5] * v.z,
          a.r[6] * v.x + a.r[7] * v.y + a.r[8] * v.z};
}
inline Vector3<double> to_world(const Pose& a, const Vector3<double>& v) { return rotate(a, v) + a.t; }
inline Vector3<double> to_local(const Pose& a, const Vector3<double>& world) {
  const Vector3<double> v = world - a.t;
  return {a.r[0] * v.x + a.r[3] * v.y + a.r[6] * v.z, a.r[1] * v.x + a.r[4] * v.y + a.r[7] * v.z,
          a.r[2] * v.x + a.r[5] * v.y + a.r[8] * v.z};
}

/// Between keyframes: linear in translation; about a common axis linear in the angle (whole turns count), otherwise
/// the shortest spherical-linear turn. Before the first and after the last it rests there. No keyframe: identity.
Pose pose_at(const std::vector<Keyframe>& motion, double time);

}  // namespace malha
