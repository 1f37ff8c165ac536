// SPDX-License-Identifier: Apache-2.0
#include "host/attachments/object_motion.h"

#include <algorithm>

#include "host/animation/animation.h"

namespace malha {

namespace {

/// The vertices of an object from code in its frame; `vertex(i)` is the number of the i-th.
template <class Vertex>
std::vector<Vec3> points_from_code(const EnvironmentMesh& object, std::size_t count, const Vertex& vertex,
                                   double time) {
  const SetVertices& set = object.set;
  const double s = set.to.empty() ? 0 : std::clamp((time - set.start) / (set.end - set.start), 0.0, 1.0);
  const std::vector<Vec3>& from = set.to.empty() ? object.mesh.points : s < 1 ? set.from : set.to;
  std::vector<Vec3> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = vertex(i);
    points[i] = from[v];
    for (int k = 0; s > 0 && s < 1 && k < 3; ++k) points[i][k] += (set.to[v][k] - points[i][k]) * s;
  }
  return points;
}

void place(const EnvironmentMesh& object, double time, std::vector<Vec3>& points) {
  const Pose pose = pose_at(object.spec.motion, time);
  if (!pose.moves) return;
  for (Vec3& x : points) {
    const Vector3<double> at = to_world(pose, {x[0], x[1], x[2]});
    x = {at.x, at.y, at.z};
  }
}

}  // namespace

std::vector<Vec3> points_in_frame(const EnvironmentMesh& object, double time) {
  const std::size_t count = object.mesh.points.size();
  if (!object.animation) {
    if (object.set.to.empty()) return object.mesh.points;
    return points_from_code(
        object, count, [](std::size_t i) { return i; }, time);
  }
  std::vector<Vec3> points(count);
  object.animation->sample(time, points);
  return points;
}

std::vector<Vec3> points_at(const EnvironmentMesh& object, double time) {
  std::vector<Vec3> points = points_in_frame(object, time);
  place(object, time, points);
  return points;
}

SomeVertices::SomeVertices(const EnvironmentMesh& object, const std::vector<int>& vertices)
    : object_(&object), vertices_(vertices) {
  if (object.animation) animation_ = object.animation->select(vertices);
}

std::vector<Vec3> SomeVertices::at(double time) const {
  std::vector<Vec3> points(vertices_.size());
  if (animation_)
    animation_->sample(time, points);
  else
    points = points_from_code(
        *object_, points.size(), [this](std::size_t i) { return static_cast<std::size_t>(vertices_[i]); }, time);
  place(*object_, time, points);
  return points;
}

Mesh mesh_at(const EnvironmentMesh& object, double time) {
  Mesh mesh = object.mesh;
  mesh.points = points_at(object, time);
  return mesh;
}

}  // namespace malha
