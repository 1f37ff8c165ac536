// SPDX-License-Identifier: Apache-2.0
// A flat sheet of triangles of different forms and sizes, for tests that must not depend on a regular grid.
#pragma once
#include <sstream>
#include <string>

#include "malha/mesh.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"

namespace malha {

/// 1 x 2 m in x and z, the first row at z = 0, of triangles of many forms and sizes: points moved by up to 0.4 of a
/// cell (those of the rim along it), diagonals either way, cells five times as large at one end as at the other where
/// it is `graded`.
inline Mesh mixed_sheet(int cells, bool graded, unsigned seed) {
  Random random(seed);
  Mesh mesh;
  const auto place = [&](int k, int count) {
    const double t = (k + (k > 0 && k < count ? random(-0.4, 0.4) : 0)) / count;
    return graded ? (0.4 + 0.6 * t) * t : t;
  };
  for (int j = 0; j <= 2 * cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = place(i, cells), z = 2 * place(j, 2 * cells);
      mesh.points.push_back({x, 0, z});
    }
  const auto is_turned = [&](int a, int b, int c) {
    const Vec3 u = mesh.points[b] - mesh.points[a], v = mesh.points[c] - mesh.points[a];
    return u[2] * v[0] - u[0] * v[2] < 0.05 * length(u) * length(v);
  };
  for (int j = 0; j < 2 * cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + 1, d = a + cells + 1, c = d + 1;
      const bool first = !is_turned(a, d, c) && !is_turned(a, c, b),
                 second = !is_turned(a, d, b) && !is_turned(b, d, c);
      if (first && (!second || random(0, 1) < 0.5))
        mesh.faces.push_back({a, d, c, -1}), mesh.faces.push_back({a, c, b, -1});
      else
        mesh.faces.push_back({a, d, b, -1}), mesh.faces.push_back({b, d, c, -1});
    }
  return mesh;
}

/// The mesh as text of an OBJ file, with `more` lines between its points and its faces.
inline std::string obj_of(const Mesh& mesh, const std::string& more = "") {
  std::ostringstream text;
  text.precision(17);
  for (const Vec3& p : mesh.points) text << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  text << more;
  for (const Quad& face : mesh.faces) {
    text << 'f';
    for (const int corner : face)
      if (corner >= 0) text << ' ' << corner + 1;
    text << '\n';
  }
  return text.str();
}

}  // namespace malha
