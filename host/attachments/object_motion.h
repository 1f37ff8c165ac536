// SPDX-License-Identifier: Apache-2.0
// The positions of environment objects' vertices over time.
#pragma once
#include <memory>
#include <vector>

#include "host/attachments/pose.h"
#include "host/model/model.h"

namespace malha {

/// Tells whether the vertices of an object move against each other.
inline bool deforms(const EnvironmentMesh& object) { return object.spec.animation.has_value(); }
/// Tells whether an object moves rigidly, and whether it moves at all.
inline bool moves_rigidly(const EnvironmentMesh& object) { return !deforms(object) && !object.spec.motion.empty(); }
inline bool moves(const EnvironmentMesh& object) { return deforms(object) || !object.spec.motion.empty(); }

/// Vertices of an object, in memory that later calls use again.
struct VertexBuffer {
  std::vector<Vec3> points;
  PoseMemory memory{};
};
/// The vertices of an object at a time (s), in its frame and in the world, m.
const std::vector<Vec3>& points_in_frame(const EnvironmentMesh& object, double time, VertexBuffer& to);
const std::vector<Vec3>& points_at(const EnvironmentMesh& object, double time, VertexBuffer& to);
std::vector<Vec3> points_in_frame(const EnvironmentMesh& object, double time);
std::vector<Vec3> points_at(const EnvironmentMesh& object, double time);

/// The mesh of an object at a time, in the world.
Mesh mesh_at(const EnvironmentMesh& object, double time);

/// Some vertices of an object over time, without what the others cost.
class SomeVertices {
 public:
  SomeVertices(const EnvironmentMesh& object, const std::vector<int>& vertices);
  /// Returns their positions at a time (s) in the world, m, until the next call.
  const std::vector<Vec3>& at(double time);

 private:
  const EnvironmentMesh* object_;
  std::vector<int> vertices_;
  VertexBuffer at_;
  std::shared_ptr<const Animation> animation_;  // of these alone; null: none, or from code
};

}  // namespace malha
