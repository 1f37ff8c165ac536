// SPDX-License-Identifier: Apache-2.0
// Membrane sheets on triangles of unequal sizes and windings, and the quantities that tests measure on them.
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "malha/mesh.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {

inline ConstraintSpec membrane(double Y, double nu) {
  ConstraintSpec spec = stiff("membrane", {}, 1, nu);
  spec.young_modulus = Y;
  return spec;
}

/// Triangles about [0, width] x [-height, 0]: a lattice of jittered points with diagonals at random, of whose triangles
/// a fifth are cut into three, and half are wound the other way.
inline Mesh uneven_sheet(double width, double height, int across, int down, unsigned seed) {
  Random random(seed);
  Mesh mesh;
  for (int j = 0; j <= down; ++j)
    for (int i = 0; i <= across; ++i) {
      const double u = random(-0.3, 0.3), v = random(-0.3, 0.3);
      mesh.points.push_back(
          {width / across * (i + (i % across ? u : 0)), -height / down * (j + (j % down ? v : 0)), 0});
    }
  const auto add = [&](int a, int b, int c) {
    mesh.faces.push_back(random() < 0 ? Quad{a, b, c, -1} : Quad{b, a, c, -1});
  };
  const auto cut = [&](int a, int b, int c) {
    if (random.below(5) > 0) return add(a, b, c);
    const Vec3 &A = mesh.points[a], &B = mesh.points[b], &C = mesh.points[c];
    const int middle = static_cast<int>(mesh.points.size());
    mesh.points.push_back({(A[0] + B[0] + C[0]) / 3, (A[1] + B[1] + C[1]) / 3, 0});
    add(a, b, middle), add(b, c, middle), add(c, a, middle);
  };
  for (int j = 0; j < down; ++j)
    for (int i = 0; i < across; ++i) {
      const int a = j * (across + 1) + i, b = a + 1, c = a + across + 1, d = c + 1;
      if (random() < 0)
        cut(a, b, d), cut(a, d, c);
      else
        cut(a, b, c), cut(b, d, c);
    }
  return mesh;
}

inline MeshFile written(const TemporaryFolder& folder, const Mesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  for (const Vec3& at : mesh.points) text << "v " << at[0] << ' ' << at[1] << ' ' << at[2] << '\n';
  for (const Quad& face : mesh.faces) text << "f " << face[0] + 1 << ' ' << face[1] + 1 << ' ' << face[2] + 1 << '\n';
  return {folder.write("mesh.obj", text.str())};
}

inline Eigen::Matrix<double, 3, 2> sides_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  Eigen::Matrix<double, 3, 2> sides;
  for (int k = 0; k < 3; ++k) sides(k, 0) = b[k] - a[k], sides(k, 1) = c[k] - a[k];
  return sides;
}

/// The deformation gradient F of a triangle whose rest positions lie in the plane of x and y.
inline Eigen::Matrix<double, 3, 2> gradient_of(const std::vector<Vec3>& X, const std::vector<Vec3>& x, const Quad& t) {
  return sides_of(x[t[0]], x[t[1]], x[t[2]]) * sides_of(X[t[0]], X[t[1]], X[t[2]]).topRows<2>().inverse();
}

inline double area_of(const std::vector<Vec3>& X, const Quad& t) {
  return std::abs(sides_of(X[t[0]], X[t[1]], X[t[2]]).topRows<2>().determinant()) / 2;
}
inline double area_of(const Mesh& mesh) {
  double area = 0;
  for (const Quad& t : mesh.faces) area += area_of(mesh.points, t);
  return area;
}

/// The points of the upper edge, y = 0.
inline ListPin upper_edge(const Mesh& mesh) {
  ListPin held;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (mesh.points[i][1] == 0) held.particles.push_back(static_cast<int>(i));
  return held;
}

}  // namespace malha
