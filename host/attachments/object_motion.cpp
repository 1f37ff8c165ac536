// SPDX-License-Identifier: Apache-2.0
#include "host/attachments/object_motion.h"

#include <algorithm>
#include <utility>

#include "host/animation/animation.h"

namespace malha {

namespace {

/// Sets `points` to vertices of an object from code in its frame; `vertex(i)` is the number of the i-th.
template <class Vertex>
void set_points_from_code(const EnvironmentMesh& object, const Vertex& vertex, double time, std::vector<Vec3>& points) {
  const SetVertices& set = object.set;
  const double s = set.to.empty() ? 0 : std::clamp((time - set.start) / (set.end - set.start), 0.0, 1.0);
  const std::vector<Vec3>& from = set.to.empty() ? object.mesh.points : s < 1 ? set.from : set.to;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t v = vertex(i);
    points[i] = from[v];
    for (int k = 0; s > 0 && s < 1 && k < 3; ++k) points[i][k] += (set.to[v][k] - points[i][k]) * s;
  }
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

const std::vector<Vec3>& points_in_frame(const EnvironmentMesh& object, double time, VertexBuffer& to) {
  to.points.resize(object.mesh.points.size());
  if (object.animation)
    object.animation->sample(time, to.points, to.memory);
  else if (object.set.to.empty())
    to.points = object.mesh.points;
  else
    set_points_from_code(
        object, [](std::size_t i) { return i; }, time, to.points);
  return to.points;
}
const std::vector<Vec3>& points_at(const EnvironmentMesh& object, double time, VertexBuffer& to) {
  points_in_frame(object, time, to);
  place(object, time, to.points);
  return to.points;
}
std::vector<Vec3> points_in_frame(const EnvironmentMesh& object, double time) {
  VertexBuffer to;
  points_in_frame(object, time, to);
  return std::move(to.points);
}
std::vector<Vec3> points_at(const EnvironmentMesh& object, double time) {
  VertexBuffer to;
  points_at(object, time, to);
  return std::move(to.points);
}

SomeVertices::SomeVertices(const EnvironmentMesh& object, const std::vector<int>& vertices)
    : object_(&object), vertices_(vertices) {
  if (object.animation) animation_ = object.animation->select(vertices);
}

const std::vector<Vec3>& SomeVertices::at(double time) {
  at_.points.resize(vertices_.size());
  if (animation_)
    animation_->sample(time, at_.points, at_.memory);
  else
    set_points_from_code(
        *object_, [this](std::size_t i) { return static_cast<std::size_t>(vertices_[i]); }, time, at_.points);
  place(*object_, time, at_.points);
  return at_.points;
}

Mesh mesh_at(const EnvironmentMesh& object, double time) {
  Mesh mesh = object.mesh;
  mesh.points = points_at(object, time);
  return mesh;
}

}  // namespace malha
