// SPDX-License-Identifier: Apache-2.0
// An irregular sheet of triangles, as an OBJ file.
#pragma once
#include <string>

#include "tests/numbers.h"

namespace malha {

/// A sheet of `width` x `length` (m) of triangles whose inner vertices are moved at random and whose diagonals are
/// chosen at random. With a quarter of a cell or more, triangles could flip.
inline std::string irregular_sheet(double width, double length, int across, int along, Random& random) {
  std::string obj;
  const double a = width / across, b = length / along;
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i <= across; ++i) {
      const double dx = i > 0 && i < across ? 0.2 * random() : 0, dz = j > 0 && j < along ? 0.2 * random() : 0;
      obj += "v " + std::to_string((i + dx) * a) + " 0 " + std::to_string((j + dz) * b) + "\n";
    }
  const auto face = [&](int p, int q, int r) {
    obj += "f " + std::to_string(p) + " " + std::to_string(q) + " " + std::to_string(r) + "\n";
  };
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < across; ++i) {
      const int p = j * (across + 1) + i + 1, q = p + 1, r = p + across + 1, s = r + 1;
      if (random() < 0)
        face(p, r, q), face(q, r, s);
      else
        face(p, r, s), face(p, s, q);
    }
  return obj;
}

}  // namespace malha
