// SPDX-License-Identifier: Apache-2.0
// A box of hexahedral cells, each split into six tetrahedra that share the cell's long diagonal.
#pragma once
#include <algorithm>
#include <array>
#include <utility>

#include "malha/scene.h"

namespace malha {

/// The box is centred at the origin, like tet_box.
inline MeshDataShape cells_of_six(const Vec3& size, const std::array<int, 3>& cells) {
  const auto number = [&](const std::array<int, 3>& at) {
    return (at[0] * (cells[1] + 1) + at[1]) * (cells[2] + 1) + at[2];
  };
  MeshDataShape shape;
  for (int i = 0; i <= cells[0]; ++i)
    for (int j = 0; j <= cells[1]; ++j)
      for (int k = 0; k <= cells[2]; ++k)
        shape.points.push_back({size[0] * (double(i) / cells[0] - 0.5), size[1] * (double(j) / cells[1] - 0.5),
                                size[2] * (double(k) / cells[2] - 0.5)});
  for (int i = 0; i < cells[0]; ++i)
    for (int j = 0; j < cells[1]; ++j)
      for (int k = 0; k < cells[2]; ++k) {
        std::array<int, 3> axes{0, 1, 2};
        do {  // from corner to opposite corner, along each of the six orders of the axes
          std::array<int, 3> at{i, j, k};
          Tetrahedron t{number(at), 0, 0, 0};
          for (int step = 0; step < 3; ++step) ++at[axes[step]], t[step + 1] = number(at);
          const bool even = (axes[1] - axes[0] + 3) % 3 == 1;
          if (!even) std::swap(t[2], t[3]);
          shape.tetrahedra.push_back(t);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return shape;
}

}  // namespace malha
