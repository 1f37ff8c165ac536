// SPDX-License-Identifier: Apache-2.0
// Volume and lumped masses of host/mesh/topology.h.
#include "host/mesh/tetrahedra.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

double signed_volume(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  if (triangles.empty()) return 0;
  // Taking one of the points as the origin keeps the precision of a small mesh far from the origin.
  const Vec3 origin = points[triangles[0][0]];
  double six_times = 0;
  for (const auto& [a, b, c] : triangles) {
    six_times += dot(cross(minus(points[a], origin), minus(points[b], origin)), minus(points[c], origin));
  }
  return six_times / 6;
}

std::vector<double> masses_by_density(const Mesh& mesh, double density) {
  const auto& points = mesh.points;
  std::vector<double> mass(points.size(), 0.0);
  const auto normal_of = [&](int a, int b, int c) {
    return cross(minus(points[b], points[a]), minus(points[c], points[a]));
  };
  const auto add_triangle = [&](const Triangle& corners, const Vec3& normal, double weight) {
    const double third = weight * density * norm(normal) / 2 / 3;
    for (const int corner : corners) mass[corner] += third;
  };
  for (const Tetrahedron& tetrahedron : mesh.tetrahedra)
    for (const int corner : tetrahedron) mass[corner] += density * volume(points, tetrahedron) / 4;
  const std::vector<Quad> none;
  for (const auto& [a, b, c, d] : mesh.tetrahedra.empty() ? mesh.faces : none) {
    if (d < 0) {
      add_triangle({a, b, c}, normal_of(a, b, c), 1);
    } else {
      // One diagonal of a concave quad lies outside of it; the triangles along that one have opposite normals.
      const Vec3 abc = normal_of(a, b, c), acd = normal_of(a, c, d), bcd = normal_of(b, c, d), bda = normal_of(b, d, a);
      const bool first = dot(abc, acd) >= 0, second = dot(bcd, bda) >= 0;
      const double share = first == second ? 0.5 : first ? 1 : 0;
      add_triangle({a, b, c}, abc, share), add_triangle({a, c, d}, acd, share);
      add_triangle({b, c, d}, bcd, 1 - share), add_triangle({b, d, a}, bda, 1 - share);
    }
  }
  for (const auto& [a, b] : mesh.lines) {
    const double half = density * norm(minus(points[b], points[a])) / 2;
    mass[a] += half, mass[b] += half;
  }
  return mass;
}

std::vector<double> masses_by_total(const Mesh& mesh, double mass) {
  std::vector<double> masses = masses_by_density(mesh, 1);
  const double equal_share = mass / static_cast<double>(masses.size());
  double shared = 0, for_shared = mass;
  for (const double part : masses) {
    shared += part;
    if (part == 0) for_shared -= equal_share;
  }
  for (double& part : masses) part = part == 0 ? equal_share : part / shared * for_shared;
  return masses;
}

}  // namespace malha
