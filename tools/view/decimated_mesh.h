// SPDX-License-Identifier: Apache-2.0
// Decimation of very large meshes for drawing without a GPU while anything moves.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace malha::view {

/// A subset of a mesh's particles with the elements between them; each represents those around it.
struct DecimatedMesh {
  std::vector<unsigned> particles;                 // indices in the mesh
  std::vector<std::array<unsigned, 3>> triangles;  // indices in `particles`
  std::vector<std::array<unsigned, 2>> edges;
};

/// Keeps about one particle in `share` (at least 2), and at least one of every connected part; parts are never joined.
/// `count`: particles of the mesh. Time and memory are linear in the mesh.
DecimatedMesh decimate(std::size_t count, const std::vector<std::array<unsigned, 3>>& triangles,
                       const std::vector<std::array<unsigned, 2>>& edges, double share);

}  // namespace malha::view
