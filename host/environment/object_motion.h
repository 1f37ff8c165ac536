// SPDX-License-Identifier: Apache-2.0
// Where the vertices of environment objects are over time.
#pragma once
#include <vector>

#include "host/attachments/pose.h"
#include "host/model/model.h"

namespace malha {

/// Tells whether the vertices of an object move against each other.
inline bool deforms(const EnvironmentMesh& object) { return object.spec.animation.has_value(); }
/// Tells whether an object moves at all.
inline bool moves(const EnvironmentMesh& object) { return deforms(object) || !object.spec.motion.empty(); }

/// The vertices of an object at a time (s), in its frame and in the world, m.
std::vector<Vec3> points_in_frame(const EnvironmentMesh& object, double time);
std::vector<Vec3> points_at(const EnvironmentMesh& object, double time);

/// The mesh of an object at a time, in the world.
Mesh mesh_at(const EnvironmentMesh& object, double time);

}  // namespace malha
