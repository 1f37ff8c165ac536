// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/weld.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "host/base/disjoint_sets.h"
#include "host/mesh/first_equal.h"
#include "host/mesh/tetrahedra.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"

namespace malha {

namespace {

/// The lowest point of each point's cluster. Points are sorted into cubes as wide as the distance, so that all points
/// within it are in the 27 cubes around. Points in the same eighth of a cube are within the distance of each other, so
/// that cubes with many points take no more time.
std::vector<int> lowest_of_cluster(const std::vector<Vec3>& points, double distance) {
  using Cube = std::array<double, 3>;  // integral coordinates
  const auto hash = [](const Cube& cube) {
    std::uint64_t bits = 0;
    for (const double k : cube) bits = mix(bits, std::bit_cast<std::uint64_t>(k + 0.0));
    return static_cast<std::size_t>(bits);
  };
  const int count = static_cast<int>(points.size());
  DisjointSets sets(count);
  const auto join_if_near = [&](int a, int b) {
    const bool near = squared_distance(points[a], points[b]) <= distance * distance;
    if (near) sets.join(a, b);
    return near;
  };
  using Eighths = std::map<int, std::vector<int>>;
  std::unordered_map<Cube, Eighths, decltype(hash)> cubes(points.size(), hash);
  for (int i = 0; i < count; ++i) {
    Cube cube;
    int eighth = 0;
    for (int k = 0; k < 3; ++k) {
      const double half = std::floor(points[i][k] / (distance / 2));
      cube[k] = std::floor(half / 2), eighth = 2 * eighth + (half != 2 * cube[k] ? 1 : 0);
    }
    std::vector<int>& same = cubes[cube][eighth];
    if (!same.empty()) join_if_near(same.front(), i);
    same.push_back(i);
  }
  const auto join_any = [&](const std::vector<int>& some, const std::vector<int>& others) {
    if (sets.root(some.front()) == sets.root(others.front())) return;
    for (const int a : some)
      for (const int b : others)
        if (join_if_near(a, b)) return;
  };
  for (const auto& [cube, eighths] : cubes)
    for (int neighbour = 13; neighbour < 27; ++neighbour) {  // the cube itself, and half of its neighbours
      const auto there =
          cubes.find({cube[0] + neighbour % 3 - 1, cube[1] + neighbour / 3 % 3 - 1, cube[2] + neighbour / 9 - 1});
      if (there == cubes.end()) continue;
      for (const auto& [one, some] : eighths)
        for (const auto& [other, others] : there->second)
          if (neighbour > 13 || one < other) join_any(some, others);
    }
  std::vector<int> lowest(points.size());
  for (int i = 0; i < count; ++i) lowest[i] = sets.root(i);
  return lowest;
}

/// Replaces every point by the point `representative`, itself or a lower one, or removes it at -1. Renumbers
/// everything.
void compact_points(Mesh& mesh, const std::vector<int>& representative) {
  FileVertices& file = mesh.vertices;
  if (file.point.empty()) file = {points_of_vertices({}, static_cast<int>(representative.size())), mesh.points, {}};
  std::vector<int> now(representative.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < representative.size(); ++i) {
    if (representative[i] < 0) continue;
    const bool stays = representative[i] == static_cast<int>(i);
    now[i] = stays ? count : now[representative[i]];
    if (stays) mesh.points[count++] = mesh.points[i];
  }
  mesh.points.resize(count);
  for (int& point : file.point)
    if (point >= 0) point = now[point];
  const auto renumber = [&now](auto& items) {
    for (auto& item : items)
      for (int& corner : item)
        if (corner >= 0) corner = now[corner];
  };
  renumber(mesh.faces), renumber(mesh.lines), renumber(mesh.tetrahedra);
}

/// Removes corners of a face that equal the one before. Returns false if less than three are left. `in_file` is the
/// same face by vertices of the file.
bool remove_equal_corners(Quad& face, Quad& in_file) {
  Quad left{-1, -1, -1, -1}, left_in_file = left;
  int corners = 0;
  for (int k = 0; k < 4; ++k)
    if (face[k] >= 0 && (corners == 0 || left[corners - 1] != face[k]))
      left[corners] = face[k], left_in_file[corners++] = in_file[k];
  if (corners > 1 && left[corners - 1] == left[0]) --corners, left[corners] = left_in_file[corners] = -1;
  face = left, in_file = left_in_file;
  return corners >= 3;
}

/// Removes equal corners of all faces. Returns the number of faces that were removed.
int remove_equal_corners(std::vector<Quad>& faces, std::vector<Quad>& in_file) {
  std::size_t left = 0;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    Quad face = faces[f], same = in_file[f];
    if (remove_equal_corners(face, same)) faces[left] = face, in_file[left++] = same;
  }
  const auto removed = static_cast<int>(faces.size() - left);
  faces.resize(left), in_file.resize(left);
  return removed;
}

}  // namespace

Welded weld(Mesh& mesh, double distance, const std::string& file) {
  const std::vector<int> representative =
      distance > 0 ? lowest_of_cluster(mesh.points, distance) : first_at_same_position(mesh.points);
  Welded done;
  for (std::size_t i = 0; i < representative.size(); ++i) done.merged += representative[i] != static_cast<int>(i);
  if (done.merged == 0) return done;
  std::vector<Quad> in_file = mesh.faces;
  compact_points(mesh, representative);
  done.removed += remove_equal_corners(mesh.faces, in_file);
  done.removed += static_cast<int>(std::erase_if(mesh.lines, [](const Edge& line) { return line[0] == line[1]; }));
  if (mesh.tetrahedra.empty()) mesh.vertices.faces = std::move(in_file);
  complete_tetrahedra(mesh, file);  // merged tetrahedra have another surface
  return done;
}

int drop_unused_points(Mesh& mesh) {
  std::vector<bool> used(mesh.points.size(), false);
  mark_corners(mesh.faces, used), mark_corners(mesh.lines, used), mark_corners(mesh.tetrahedra, used);
  const auto unused = static_cast<int>(std::ranges::count(used, false));
  if (unused == 0 || unused == static_cast<int>(used.size())) {
    mesh.vertices.position = {};
    return 0;
  }
  std::vector<int> representative = points_of_vertices({}, static_cast<int>(used.size()));
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!used[i]) representative[i] = -1;
  compact_points(mesh, representative);
  return unused;
}

std::vector<int> points_of_vertices(const FileVertices& file, int points) {
  std::vector<int> all = file.point;
  for (int i = all.empty() ? 0 : *std::ranges::max_element(all) + 1; i < points; ++i) all.push_back(i);
  return all;
}

int vertex_of(const FileVertices& file, int point) {
  if (file.point.empty()) return point;
  const std::vector<int> points = points_of_vertices(file, point + 1);
  return static_cast<int>(std::ranges::find(points, point) - points.begin());
}

}  // namespace malha
