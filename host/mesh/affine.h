// SPDX-License-Identifier: Apache-2.0
// Affine maps of positions, for set-up and animation. Eigen would contract products and sums, so that bits would depend
// on the instruction set.
#pragma once
#include <array>
#include <cstddef>

#include "malha/mesh.h"

namespace malha {

/// The map x -> M x + t, by columns: three of M, then t.
struct Affine {
  std::array<double, 12> m{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
};

inline Vec3 operator*(const Affine& map, const Vec3& x) {
  Vec3 y;
  for (std::size_t k = 0; k < 3; ++k)
    y[k] = (map.m[k] * x[0] + map.m[3 + k] * x[1]) + (map.m[6 + k] * x[2] + map.m[9 + k]);
  return y;
}

/// The map x -> a (b x).
inline Affine operator*(const Affine& a, const Affine& b) {
  Affine c;
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t k = 0; k < 3; ++k) {
      const double* of = &b.m[3 * j];
      c.m[3 * j + k] = (a.m[k] * of[0] + a.m[3 + k] * of[1]) + a.m[6 + k] * of[2];
      if (j == 3) c.m[9 + k] += a.m[9 + k];
    }
  return c;
}

/// The determinant of M; below 0 where the map mirrors.
inline double determinant(const Affine& map) {
  const auto& m = map.m;
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[3] * (m[1] * m[8] - m[2] * m[7]) + m[6] * (m[1] * m[5] - m[2] * m[4]);
}

}  // namespace malha
