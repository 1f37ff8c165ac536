// Flat triangle meshes that are no grids: points off their lattice, diagonals at random.
#pragma once
#include <cstdio>
#include <string>

#include "tests/numbers.h"

namespace malha {

/// An OBJ file of width x length m in the plane y = 0, columns x rows cells of two triangles each, all faces up. Inner
/// points are off by up to `off` of a cell, those of the rim along it, those of the first `straight` rows not at all;
/// diagonals run either way.
inline std::string irregular_obj(double width, double length, int columns, int rows, double off, unsigned seed,
                                 int straight = 0) {
  Random random(seed);
  std::string text;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double dx = random(-off, off), dz = random(-off, off);
      const bool corner = (i == 0 || i == columns) && (j == 0 || j == rows);
      const bool still = corner || j < straight;
      const double x = i + (still || i == 0 || i == columns ? 0 : dx), z = j + (still || j == 0 || j == rows ? 0 : dz);
      char line[96];
      std::snprintf(line, sizeof line, "v %.17g 0 %.17g\n", x * width / columns, z * length / rows);
      text += line;
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i + 1, b = a + 1, c = b + columns + 1, d = a + columns + 1;
      char lines[96];
      if (random.below(2) == 0)
        std::snprintf(lines, sizeof lines, "f %d %d %d\nf %d %d %d\n", a, d, c, a, c, b);
      else
        std::snprintf(lines, sizeof lines, "f %d %d %d\nf %d %d %d\n", a, d, b, b, d, c);
      text += lines;
    }
  return text;
}

}  // namespace malha
