// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/topology.h"

#include "host/base/disjoint_sets.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/vertices.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

std::vector<Edge> edges(const Mesh& mesh) {
  const auto visit = [&](auto add) {
    for_each_face_side(mesh.faces, add);
    for (const auto& [from, to] : mesh.lines) add(from, to);
    for (const auto& [a, b, c, d] : mesh.tetrahedra) add(a, b), add(a, c), add(a, d), add(b, c), add(b, d), add(c, d);
  };
  std::size_t most = 0, unique = 0;
  visit([&](int, int) { ++most; });
  std::vector<bool> is_first(most, false);
  for_each_edge(sorted_sides(mesh.points.size(), visit), [&](auto first, auto) {
    is_first[first->number] = true;
    ++unique;
  });
  std::vector<Edge> found;
  found.reserve(unique);
  std::size_t number = 0;
  visit([&](int from, int to) {
    if (is_first[number++]) found.push_back({std::min(from, to), std::max(from, to)});
  });
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
  const Side *open = nullptr, *non_manifold = nullptr,
             *against = nullptr;  // first edge of each kind in the order of the faces
  int open_edges = 0, crowded_edges = 0, against_edges = 0;
  const auto note = [](const Side*& kept, int& count, const Side& side) {
    if (kept == nullptr || side.number < kept->number) kept = &side;
    ++count;
  };
  for_each_edge(sides, [&](auto first, auto last) {
    if (last - first == 1) {
      note(open, open_edges, *first);
    } else if (last - first > 2) {
      note(non_manifold, crowded_edges, *first);
    } else if (first[0].forward == first[1].forward) {
      note(against, against_edges, *first);
    }
  });
  const auto refuse_edge = [&](const Side& side, int count, const std::string& what) {
    const auto vertex = [&mesh](int point) { return std::to_string(vertex_of(mesh.vertices, point)); };
    refuse(file, "edge " + vertex(side.low) + "-" + vertex(side.high) + " (vertices, 0-based)",
           what + " (edges like it: " + std::to_string(count) + ")", two_faces);
  };
  if (open != nullptr) refuse_edge(*open, open_edges, "an open edge, with one face only");
  if (non_manifold != nullptr) refuse_edge(*non_manifold, crowded_edges, "an edge with more than two faces");
  if (against != nullptr) refuse_edge(*against, against_edges, "an edge whose two faces have opposite orientations");
  const double volume = signed_volume(mesh.points, triangles(mesh));
  if (!(volume > 0)) {
    refuse(file, "", "an enclosed volume of " + shown(volume) + " m^3 (inside out)",
           why + ": faces counter-clockwise seen from outside, so that the volume is positive");
  }
}

}  // namespace malha
