// SPDX-License-Identifier: Apache-2.0
#include "host/environment/object_motion.h"

#include <algorithm>

#include "host/animation/animation.h"

namespace malha {

std::vector<Vec3> points_in_frame(const EnvironmentMesh& object, double time) {
  if (object.animation) {
    std::vector<Vec3> points(object.mesh.points.size());
    object.animation->sample(time, points);
    return points;
  }
  const SetVertices& set = object.set;
  if (set.to.empty()) return object.mesh.points;
  const double s = std::clamp((time - set.start) / (set.end - set.start), 0.0, 1.0);
  if (!(s < 1)) return set.to;
  std::vector<Vec3> points = set.from;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int k = 0; k < 3; ++k) points[i][k] += (set.to[i][k] - points[i][k]) * s;
  return points;
}

std::vector<Vec3> points_at(const EnvironmentMesh& object, double time) {
  std::vector<Vec3> points = points_in_frame(object, time);
  const Pose pose = pose_at(object.spec.motion, time);
  if (!pose.moves) return points;
  for (Vec3& x : points) {
    const Vector3<double> at = to_world(pose, {x[0], x[1], x[2]});
    x = {at.x, at.y, at.z};
  }
  return points;
}

Mesh mesh_at(const EnvironmentMesh& object, double time) {
  Mesh mesh = object.mesh;
  mesh.points = points_at(object, time);
  return mesh;
}

}  // namespace malha
