// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/check_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/mesh/bounding_box.h"
#include "host/mesh/first_equal.h"
#include "host/mesh/polygons.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {
namespace {

constexpr double largest_coordinate = 1e12;     // m: lengths, areas and volumes stay finite in single precision
constexpr double zero_area_per_square = 1e-12;  // of the bounding box's diagonal

std::string number_of(const char* what, std::size_t number) {
  return std::string(what) + " " + std::to_string(number) + " (0-based)";
}

/// The number of a point as a vertex of the file.
int vertex(const Mesh& mesh, std::size_t point) { return vertex_of(mesh.vertices, static_cast<int>(point)); }

void check_coordinates(const Mesh& mesh, const std::string& file) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    for (const double value : mesh.points[i]) {
      if (std::abs(value) <= largest_coordinate) continue;  // false for NaN
      refuse(file, number_of("vertex", vertex(mesh, i)), "the coordinate " + shown(value),
             "finite numbers up to 1e12 m");
    }
  }
}

void check_duplicated_points(const Mesh& mesh, const std::string& file) {
  const std::vector<int> first = first_at_same_position(mesh.points);
  std::size_t example = first.size();
  int duplicates = 0;
  for (std::size_t i = first.size(); i-- > 0;) {
    if (first[i] == static_cast<int>(i)) continue;
    example = i;
    ++duplicates;
  }
  if (duplicates == 0) return;
  refuse(file, number_of("vertex", vertex(mesh, example)),
         "the position of vertex " + std::to_string(vertex(mesh, first[example])) +
             " again (vertices like it: " + std::to_string(duplicates) + ")",
         "one vertex for each position: \"weld\": 0 beside the \"mesh\" of a body merges them (or Blender's Merge by "
         "Distance)");
}

// Removes the halves of faces without area; returns nothing if no half remains. Quads are renumbered so that their
// halves, (0, 1, 2) and (0, 2, 3), lie inside of them.
class AreaFilter {
 public:
  explicit AreaFilter(const std::vector<Vec3>& points) : points_(points) {
    const auto [low, high] = points.empty() ? BoundingBox{} : bounds_of(points);
    const double diagonal = distance(high, low);
    limit_ = zero_area_per_square * diagonal * diagonal;
  }

  std::optional<Quad> operator()(const Quad& face) const {
    const auto [a, b, c, d] = face;
    if (is_triangle(face)) return has_area(a, b, c) ? std::optional(face) : std::nullopt;
    if (a == c || b == d) return std::nullopt;
    const bool first = has_area(a, b, c), second = has_area(a, c, d);
    if (first && second) return first_diagonal_is_outside(face) ? Quad{b, c, d, a} : face;
    if (!first && !second) return std::nullopt;
    if (has_area(b, c, d) && has_area(b, d, a)) return Quad{b, c, d, a};
    return first ? Quad{a, b, c, -1} : Quad{a, c, d, -1};
  }

  /// True if the halves (0, 1, 2) and (0, 2, 3) have opposite normals.
  bool folds(const Quad& face) const {
    const auto [a, b, c, d] = face;
    return dot(normal_of(a, b, c), normal_of(a, c, d)) < 0;
  }

 private:
  /// True if a quad is concave and its first diagonal lies outside of it.
  bool first_diagonal_is_outside(const Quad& face) const {
    const auto [a, b, c, d] = face;
    return folds(face) && !folds({b, c, d, a});
  }

  Vec3 normal_of(int a, int b, int c) const { return normal(points_[a], points_[b], points_[c]); }
  bool has_area(int a, int b, int c) const { return area(points_[a], points_[b], points_[c]) > limit_; }

  const std::vector<Vec3>& points_;
  double limit_;
};

/// The side of a quad from its k-th corner to the next, as text.
std::string side_text(const Mesh& mesh, const Quad& face, int k) {
  return std::to_string(vertex(mesh, face[k])) + "-" + std::to_string(vertex(mesh, face[(k + 1) % 4]));
}

/// The remaining corners of a face as vertices of the file.
Quad remaining_in_file(const Quad& left, const Quad& face, const Quad& in_file) {
  Quad same{-1, -1, -1, -1};
  for (int k = 0; k < 4; ++k)
    if (left[k] >= 0) same[k] = in_file[std::ranges::find(face, left[k]) - face.begin()];
  return same;
}

void check_repeated_faces(const Mesh& mesh, const std::vector<Quad>& faces, const std::vector<int>& numbers,
                          const std::string& file) {
  const std::vector<int> first = first_of_same_corners(faces);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (first[i] == static_cast<int>(i)) continue;
    std::string corners;
    for (const int corner : faces[i]) {
      if (corner >= 0) corners += (corners.empty() ? "" : ", ") + std::to_string(vertex(mesh, corner));
    }
    refuse(file, number_of("face", numbers[i]),
           "the vertices " + corners + " of face " + std::to_string(numbers[first[i]]) + " again", "every face once");
  }
}

void check_loose_points(const Mesh& mesh, const std::vector<Quad>& kept, const std::string& file) {
  std::vector<bool> used(mesh.points.size(), false);
  mark_corners(kept, used), mark_corners(mesh.lines, used), mark_corners(mesh.tetrahedra, used);
  const auto loose = std::ranges::find(used, false);
  if (loose == used.end()) return;
  const auto all = std::ranges::count(used, false);
  std::string found = "a vertex of no face, line or tetrahedron (vertices like it: " + std::to_string(all) + ")";
  mark_corners(mesh.faces, used);
  if (used[static_cast<std::size_t>(loose - used.begin())]) found = "a vertex whose faces all have zero area";
  refuse(file, number_of("vertex", vertex(mesh, static_cast<std::size_t>(loose - used.begin()))), found,
         "vertices of faces with an area, or of lines");
}

}  // namespace

int check_mesh(Mesh& mesh, const std::string& file, bool loose_points_allowed) {
  check_coordinates(mesh, file);
  check_duplicated_points(mesh, file);
  for (std::size_t i = 0; i < mesh.lines.size(); ++i) {
    if (mesh.lines[i][0] != mesh.lines[i][1]) continue;
    refuse(file, number_of("line", i), "vertex " + std::to_string(vertex(mesh, mesh.lines[i][0])) + " at both ends",
           "two vertices");
  }
  const AreaFilter filter(mesh.points);
  int zero_area_faces = 0;
  std::vector<Quad> kept, kept_in_file;
  std::vector<int> numbers;  // of the kept faces, in the mesh as given
  kept.reserve(mesh.faces.size());
  numbers.reserve(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const std::optional<Quad> left = filter(mesh.faces[i]);
    if (!left || is_triangle(*left) != is_triangle(mesh.faces[i])) ++zero_area_faces;
    if (!left) continue;
    if (!is_triangle(*left) && filter.folds(*left)) {
      const auto [a, b, c, d] = *left;
      const auto [first, second] = crossing_sides(mesh.points, {a, b, c, d});
      if (first >= 0)
        refuse(file, number_of("face", i),
               "a face of 4 corners whose sides " + side_text(mesh, *left, first) + " and " +
                   side_text(mesh, *left, second) + " (vertices, 0-based) cross",
               "faces whose sides meet at their corners only");
    }
    kept.push_back(*left);
    if (!mesh.vertices.faces.empty())
      kept_in_file.push_back(remaining_in_file(*left, mesh.faces[i], mesh.vertices.faces[i]));
    numbers.push_back(static_cast<int>(i));
  }
  check_repeated_faces(mesh, kept, numbers, file);
  if (!loose_points_allowed) check_loose_points(mesh, kept, file);
  mesh.faces = std::move(kept), mesh.vertices.faces = std::move(kept_in_file);
  return zero_area_faces;
}

}  // namespace malha
