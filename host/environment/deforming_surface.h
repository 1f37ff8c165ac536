// SPDX-License-Identifier: Apache-2.0
// Topology of a deforming mesh of the environment: its triangles in the order of their tree, and their neighbours.
#pragma once
#include <vector>

#include "host/mesh/compressed_lists.h"
#include "host/mesh/topology.h"
#include "kernels/environment/deforming_mesh.h"

namespace malha {

/// What DeformingMesh refers to, apart from positions. Vertices are in the mesh's order.
struct DeformingSurface {
  std::vector<Triangle> triangles;  // 16 that follow each other are close together, and so are 16 such groups
  std::vector<int> corner[3], neighbour[3];
  CompressedLists<int> star;  // the triangles at each vertex
  std::vector<unsigned char> rim;
};

/// Triangles that share an edge with more than one other, or wind against it, have no neighbour there.
DeformingSurface deforming_surface(const Mesh& mesh);

}  // namespace malha
