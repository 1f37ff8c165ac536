// SPDX-License-Identifier: Apache-2.0
// What of environment objects that move together can touch a deformable body beside their faces: edges and corners.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "kernels/geometry/stackless_bvh.h"

namespace malha {

/// Objects of one motion, as one. A triangle owns those of its corners and edges that can be the first to touch:
/// corners and edges of a solid that are not convex are hidden by others, and what is flat is covered by its faces.
struct EdgeSurface {
  std::vector<Vec3> points;        // relative to the centre of their box, in their own frame
  std::vector<int> object;         // of each point: 0, 1, ... as added
  std::vector<Simplex> triangles;  // every edge and corner owned by one at most
  std::vector<BoxNode> path;       // of the triangles
  Vec3 centre{};
  int edges = 0, corners = 0;  // that can touch
};

EdgeSurface edge_surface(const std::vector<const EnvironmentMesh*>& objects);

}  // namespace malha
