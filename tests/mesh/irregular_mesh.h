// SPDX-License-Identifier: Apache-2.0
// Irregular flat triangle meshes: points are moved off their lattice, and diagonals are chosen at random.
#pragma once
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/numbers.h"

namespace malha {

enum class Diagonals { Random, Alike, Delaunay };

/// An OBJ file of width x length m in the plane y = 0, columns x rows cells of two triangles each, all faces up. Inner
/// points are moved by up to `off` of a cell, those of the boundary along it, those of the first `straight` rows not at
/// all; diagonals run either way at random, all alike, or by Delaunay's criterion.
inline std::string irregular_obj(double width, double length, int columns, int rows, double off, unsigned seed,
                                 int straight = 0, Diagonals diagonals = Diagonals::Random) {
  Random random(seed);
  std::string text;
  std::vector<std::array<double, 2>> at;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double dx = random(-off, off), dz = random(-off, off);
      const bool corner = (i == 0 || i == columns) && (j == 0 || j == rows);
      const bool still = corner || j < straight;
      const double x = i + (still || i == 0 || i == columns ? 0 : dx), z = j + (still || j == 0 || j == rows ? 0 : dz);
      char line[96];
      at.push_back({x * width / columns, z * length / rows});
      std::snprintf(line, sizeof line, "v %.17g 0 %.17g\n", at.back()[0], at.back()[1]);
      text += line;
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i + 1, b = a + 1, c = b + columns + 1, d = a + columns + 1;
      char lines[96];
      // The cosine of the angle at a corner between its neighbours.
      const auto cosine = [&](int o, int p, int q) {
        const double u[2] = {at[p - 1][0] - at[o - 1][0], at[p - 1][1] - at[o - 1][1]};
        const double v[2] = {at[q - 1][0] - at[o - 1][0], at[q - 1][1] - at[o - 1][1]};
        return (u[0] * v[0] + u[1] * v[1]) / (std::hypot(u[0], u[1]) * std::hypot(v[0], v[1]));
      };
      // The diagonal a c is Delaunay's where the angles at b and d, which face it, are together below half a turn.
      const bool from_a = diagonals == Diagonals::Alike ? true
                          : diagonals == Diagonals::Random
                              ? random.below(2) == 0
                              : std::acos(cosine(b, a, c)) + std::acos(cosine(d, a, c)) < 3.14159265358979323846;
      if (from_a)
        std::snprintf(lines, sizeof lines, "f %d %d %d\nf %d %d %d\n", a, d, c, a, c, b);
      else
        std::snprintf(lines, sizeof lines, "f %d %d %d\nf %d %d %d\n", a, d, b, b, d, c);
      text += lines;
    }
  return text;
}

}  // namespace malha
