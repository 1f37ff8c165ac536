// SPDX-License-Identifier: Apache-2.0
// Edges and corners of environment objects that can touch a deformable body.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "kernels/geometry/stackless_bvh.h"

namespace malha {

/// Joined surface of the objects with a common motion. A triangle owns those of its corners and edges that can be the
/// first to touch: reflex corners and edges of a solid are hidden by others, and flat ones are covered by their faces.
/// Every corner and edge of a mesh that deforms is owned, because which of them are flat or reflex changes with its
/// pose, and no pose is known beforehand where a program sets the vertices.
struct EdgeSurface {
  std::vector<Vec3> points;        // relative to the centre of their box, in their own frame
  std::vector<int> object;         // object of each point: 0, 1, ... in the order given
  std::vector<Simplex> triangles;  // every edge and corner is owned by one at most
  std::vector<BoxNode> path;       // stackless BVH of the triangles
  Vec3 centre{};
  int edges = 0, corners = 0;  // numbers of those that can touch
};

EdgeSurface edge_surface(const std::vector<const EnvironmentMesh*>& objects);

/// The objects with "edges" that move together: all that rest, and each that moves alone; then the meshes that deform,
/// one a group.
std::vector<std::vector<const EnvironmentMesh*>> edge_groups(const Model& model);

}  // namespace malha
