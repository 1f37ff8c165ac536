// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/topology.h"

#include <algorithm>

#include "host/base/disjoint_sets.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/tetrahedra.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

std::vector<Edge> edges(const Mesh& mesh) {
  const auto visit = [&](auto add) {
    for_each_face_side(mesh.faces, add);
    for (const auto& [from, to] : mesh.lines) add(from, to);
    for (const auto& [a, b, c, d] : mesh.tetrahedra) add(a, b), add(a, c), add(a, d), add(b, c), add(b, d), add(c, d);
  };
  std::vector<Side> unique;
  for_each_edge(sorted_sides(mesh.points.size(), visit), [&](auto first, auto) { unique.push_back(*first); });
  std::ranges::sort(unique, {}, &Side::number);
  std::vector<Edge> found;
  found.reserve(unique.size());
  for (const Side& side : unique) found.push_back({side.low, side.high});
  return found;
}

std::vector<Edge> shear(const Mesh& mesh) {
  std::vector<Edge> found;
  for (const Quad& face : mesh.faces) {
    if (is_triangle(face)) continue;
    found.push_back({face[0], face[2]});
    found.push_back({face[1], face[3]});
  }
  return found;
}

std::vector<Triangle> triangles(const Mesh& mesh) {
  std::vector<Triangle> found;
  found.reserve(2 * mesh.faces.size());
  for (const Quad& face : mesh.faces) {
    found.push_back({face[0], face[1], face[2]});
    if (!is_triangle(face)) found.push_back({face[0], face[2], face[3]});
  }
  return found;
}

std::vector<int> opposite_sides(std::size_t points, const std::vector<Triangle>& triangles, int* non_manifold) {
  const auto sides = sorted_sides(points, [&](auto add) {
    for (const auto& [a, b, c] : triangles) add(a, b), add(b, c), add(c, a);
  });
  std::vector<int> other(3 * triangles.size(), -1);
  for_each_edge(sides, [&](auto first, auto last) {
    if (last - first > 2 && non_manifold != nullptr) ++*non_manifold;
    if (last - first != 2) return;
    other[first[0].number] = first[1].number, other[first[1].number] = first[0].number;
  });
  return other;
}

std::vector<std::array<int, 4>> hinges(const Mesh& mesh, int* non_manifold) {
  const std::vector<Triangle> all = triangles(mesh);
  const std::vector<int> other = opposite_sides(mesh.points.size(), all, non_manifold);
  const auto corner = [&](int side, int ahead) { return all[side / 3][(side + ahead) % 3]; };
  std::vector<std::array<int, 4>> found;
  for (int side = 0; side < static_cast<int>(other.size()); ++side)
    if (other[side] > side)
      found.push_back({corner(side, 0), corner(side, 1), corner(side, 2), corner(other[side], 2)});
  return found;
}

std::vector<int> components(int particles, const std::vector<Edge>& edges, int& count) {
  DisjointSets parts(particles);
  for (const auto& [a, b] : edges) parts.join(a, b);
  count = 0;
  std::vector<int> label(particles);
  for (int i = 0; i < particles; ++i) {
    const int lowest = parts.root(i);
    label[i] = lowest == i ? count++ : label[lowest];
  }
  return label;
}

void require_closed(const Mesh& mesh, const std::string& file, const std::string& why) {
  const auto two_faces = why + ": every edge with exactly two faces, consistently oriented";
  if (mesh.faces.empty()) refuse(file, "", "a mesh without faces", two_faces);
  const auto sides = sorted_sides(mesh.points.size(), [&](auto add) { for_each_face_side(mesh.faces, add); });
  struct Fault {
    std::string what;
    const Side* first = nullptr;  // in the order of the faces
    int edges = 0;
  };
  Fault faults[] = {{"an open edge, with one face only"},
                    {"an edge with more than two faces"},
                    {"an edge whose two faces have opposite orientations"}};
  for_each_edge(sides, [&](auto first, auto last) {
    if (last - first == 2 && first[0].forward != first[1].forward) return;
    Fault& fault = faults[last - first == 1 ? 0 : last - first > 2 ? 1 : 2];
    if (fault.edges++ == 0 || first->number < fault.first->number) fault.first = &*first;
  });
  for (const Fault& fault : faults) {
    if (fault.edges == 0) continue;
    const auto vertex = [&mesh](int point) { return std::to_string(vertex_of(mesh.vertices, point)); };
    refuse(file, "edge " + vertex(fault.first->low) + "-" + vertex(fault.first->high) + " (vertices, 0-based)",
           fault.what + " (edges like it: " + std::to_string(fault.edges) + ")", two_faces);
  }
  const double volume = signed_volume(mesh.points, triangles(mesh));
  if (!(volume > 0)) {
    refuse(file, "", "an enclosed volume of " + shown(volume) + " m^3 (inside out)",
           why + ": faces counter-clockwise seen from outside, so that the volume is positive");
  }
}

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

std::vector<double> masses_by_density(const Mesh& mesh, double density, const Mesh& rest) {
  const auto& points = rest.points;
  std::vector<double> mass(mesh.points.size(), 0.0);
  const auto normal_of = [&](int a, int b, int c) { return normal(points[a], points[b], points[c]); };
  const auto add_triangle = [&](const Triangle& corners, const Vec3& normal, double weight) {
    const double third = weight * density * norm(normal) / 2 / 3;
    for (const int corner : corners) mass[corner] += third;
  };
  for (const Tetrahedron& tetrahedron : mesh.tetrahedra)
    for (const int corner : tetrahedron) mass[corner] += density * volume(points, tetrahedron) / 4;
  for (std::size_t f = 0; f < mesh.faces.size() && mesh.tetrahedra.empty(); ++f) {
    const auto& [a, b, c, d] = mesh.faces[f];
    const auto& [A, B, C, D] = rest.faces[f];
    if (d < 0) {
      add_triangle({a, b, c}, normal_of(A, B, C), 1);
    } else {
      // One diagonal of a concave quad lies outside of it; the triangles along that one have opposite normals.
      const Vec3 abc = normal_of(A, B, C), acd = normal_of(A, C, D), bcd = normal_of(B, C, D), bda = normal_of(B, D, A);
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

std::vector<double> masses_by_total(const Mesh& mesh, double mass, const Mesh& rest) {
  std::vector<double> masses = masses_by_density(mesh, 1, rest);
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
