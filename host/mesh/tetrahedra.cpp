// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/tetrahedra.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/mesh/first_equal.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {
namespace {

constexpr double no_volume = 1e-6;  // volume over the cube of the longest edge; flat in single precision

/// The triangle opposite to corner k, counter-clockwise seen from outside.
constexpr int kOpposite[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

std::string place(std::size_t tetrahedron) { return "tetrahedron " + std::to_string(tetrahedron) + " (0-based)"; }

std::string vertex(const Mesh& mesh, int point) { return std::to_string(vertex_of(mesh.vertices, point)); }

void orient(const Mesh& mesh, Tetrahedron& corners, std::size_t number, const std::string& file) {
  const std::vector<Vec3>& points = mesh.points;
  double longest = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) {
      if (corners[a] == corners[b])
        refuse(file, place(number), "vertex " + vertex(mesh, corners[a]) + " as two of its corners", "four vertices");
      longest = std::max(longest, distance(points[corners[a]], points[corners[b]]));
    }
  const double V = volume(points, corners);
  if (!(std::abs(V) > no_volume * longest * longest * longest))
    refuse(file, place(number), "a volume of " + shown(V) + " m^3 at a longest edge of " + shown(longest) + " m",
           "more than 1e-6 of that edge's cube: no flat tetrahedra");
  if (V < 0) std::swap(corners[2], corners[3]);
}

}  // namespace

double volume(const std::vector<Vec3>& points, const Tetrahedron& tetrahedron) {
  const auto from_first = [&](int corner, int axis) {
    return points[tetrahedron[corner]][axis] - points[tetrahedron[0]][axis];
  };
  double six_times = 0;
  for (int x = 0; x < 3; ++x) {
    const int y = (x + 1) % 3, z = (x + 2) % 3;
    six_times += from_first(1, x) * (from_first(2, y) * from_first(3, z) - from_first(2, z) * from_first(3, y));
  }
  return six_times / 6;
}

void complete_tetrahedra(Mesh& mesh, const std::string& file) {
  if (mesh.tetrahedra.empty()) return;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) orient(mesh, mesh.tetrahedra[t], t, file);

  std::vector<Triangle> sides;
  sides.reserve(4 * mesh.tetrahedra.size());
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const auto& [a, b, c] : kOpposite) sides.push_back({t[a], t[b], t[c]});
  const std::vector<int> first = first_of_same_corners(sides);
  // True if the corners are an even permutation: then both tetrahedra lie on the same side of the triangle.
  const auto have_same_orientation = [](const Triangle& a, const Triangle& b) {
    const auto at = std::ranges::find(b, a[0]) - b.begin();
    return b[(at + 1) % 3] == a[1];
  };
  std::vector<int> times(sides.size(), 0);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const int of = first[i];
    const auto refuse_side = [&](const std::string& found, const std::string& allowed) {
      const auto [a, b, c] = sides[i];
      refuse(file, place(i / 4),
             "the triangle of vertices " + vertex(mesh, a) + ", " + vertex(mesh, b) + ", " + vertex(mesh, c) + found +
                 std::to_string(of / 4),
             allowed);
    };
    if (++times[of] > 2) refuse_side(", which two others have already, the first of them tetrahedron ", "two at most");
    if (times[of] == 2 && have_same_orientation(sides[of], sides[i]))
      refuse_side(", on the same side as tetrahedron ", "tetrahedra that do not overlap, each once");
  }
  mesh.faces.clear();
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (first[i] == static_cast<int>(i) && times[i] == 1)
      mesh.faces.push_back({sides[i][0], sides[i][1], sides[i][2], -1});
}

}  // namespace malha
