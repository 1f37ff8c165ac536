// SPDX-License-Identifier: Apache-2.0
// Fewer particles for pictures of very many, while they move and are drawn without a GPU.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace malha::view {

/// Some of a mesh's particles, and how they are joined: each stands for those around it.
struct Coarse {
  std::vector<unsigned> particles;                 // of the mesh
  std::vector<std::array<unsigned, 3>> triangles;  // by their places in `particles`
  std::vector<std::array<unsigned, 2>> edges;
};

/// About one particle in `share` (at least 2). Every connected part keeps one or more; parts are never joined, however
/// close they lie. `count`: particles of the mesh. Takes time and memory in proportion to the mesh.
Coarse coarse_of(std::size_t count, const std::vector<std::array<unsigned, 3>>& triangles,
                 const std::vector<std::array<unsigned, 2>>& edges, double share);

}  // namespace malha::view
