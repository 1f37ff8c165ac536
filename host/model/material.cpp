// SPDX-License-Identifier: Apache-2.0
#include "host/model/material.h"

#include <algorithm>
#include <cmath>

#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

/// The share of their own stiffness that sides keep at least, where the diagonals alone are stiffer than the material.
constexpr double kMinSideShare = 0.05;

/// The quotient a / length2, or 0 for length 0: such an edge can neither bend nor stretch.
double quotient(double a, double length2) { return length2 > 0 ? a / length2 : 0; }

/// The squared aspect ratio of a quad: its sides 0 and 2 over its sides 1 and 3.
double squared_aspect(const Mesh& mesh, const Quad& face) {
  const auto side2 = [&](int k) { return squared_distance(mesh.points[face[k]], mesh.points[face[(k + 1) % 4]]); };
  return quotient(side2(0) + side2(2), side2(1) + side2(3));
}

/// Rounds numbers that differ from 1 by rounding only to 1.
double rounded_to_one(double a) { return std::abs(a - 1) < 1e-9 ? 1 : a; }

/// The twist energy that the hinges about a side should have on a cell of this width across it, relative to a plate. On
/// rectangles a x b, hinges about sides a with diagonally opposite wings resist twist a^2 / b^2 times as much as a
/// plate, and those about sides b by the inverse; the results for both sides together are 2, as for a plate.
double twist_about(double length2, double across2) {
  const double ratio = quotient(length2, across2);
  return ratio <= 1 ? ratio : 2 - 1 / ratio;
}

/// True if all corners of a triangle are pinned, so that it cannot bend.
bool is_fixed(const std::vector<bool>& pinned, int a, int b, int c) { return pinned[a] && pinned[b] && pinned[c]; }

}  // namespace

double face_area(const Mesh& mesh, const Quad& face) {
  const auto of = [&](int i, int j, int k) {
    return area(mesh.points[face[i]], mesh.points[face[j]], mesh.points[face[k]]);
  };
  return is_triangle(face) ? of(0, 1, 2) : 0.5 * (of(0, 1, 2) + of(0, 2, 3) + of(1, 2, 3) + of(1, 3, 0));
}

std::vector<double> edge_softness(const Mesh& mesh, const std::vector<Edge>& edges, double shear) {
  std::vector<int> face_of, number_in_face;  // of each side, in the order of for_each_face_side
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (int k = 0; k < (is_triangle(mesh.faces[f]) ? 3 : 4); ++k)
      face_of.push_back(static_cast<int>(f)), number_in_face.push_back(k);
  const int sides = static_cast<int>(face_of.size());
  // The share of the area for a side. The diagonals act along the side too, with (side / other side)^2 times their
  // shear stiffness, which is subtracted.
  const auto part_of = [&](int side) {
    const Quad& face = mesh.faces[face_of[side]];
    if (is_triangle(face)) return 1.0;
    const double aspect2 = squared_aspect(mesh, face);
    const double own2 = rounded_to_one(number_in_face[side] % 2 == 0 ? aspect2 : quotient(1, aspect2));
    return 0.5 * std::max(1 + shear * (1 - own2), kMinSideShare);
  };
  // The edges are listed after the sides, so that each group of equal ones has the sides of an edge, and then the edge.
  const auto all = sorted_sides(mesh.points.size(), [&](auto add) {
    for_each_face_side(mesh.faces, add);
    for (const auto& [from, to] : edges) add(from, to);
  });
  std::vector<double> softness(edges.size());
  for_each_edge(all, [&](auto first, auto last) {
    const double length2 = squared_distance(mesh.points[first->low], mesh.points[first->high]);
    double share = 0;
    for (auto side = first; side != last; ++side)
      if (side->number < sides) share += face_area(mesh, mesh.faces[face_of[side->number]]) * part_of(side->number);
    for (auto side = first; side != last; ++side)
      if (side->number >= sides) softness[side->number - sides] = share > 0 ? length2 / share : std::sqrt(length2);
  });
  return softness;
}

std::vector<double> shear_softness(const Mesh& mesh) {
  std::vector<double> softness;
  for (const Quad& face : mesh.faces) {
    if (is_triangle(face)) continue;
    for (int k = 0; k < 2; ++k)
      softness.push_back(
          quotient(2 * face_area(mesh, face), squared_distance(mesh.points[face[k]], mesh.points[face[k + 2]])));
  }
  return softness;
}

PlateHinges plate_hinges(const Mesh& mesh, const std::vector<bool>& pinned) {
  struct Wing {
    int face;
    std::array<int, 2> corner;  // the corners after the side and before it
  };
  std::vector<Wing> wings;  // of each side
  std::vector<double> areas;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Quad& face = mesh.faces[f];
    const int corners = is_triangle(face) ? 3 : 4;
    for (int k = 0; k < corners; ++k)
      wings.push_back({static_cast<int>(f), {face[(k + 2) % corners], face[(k + corners - 1) % corners]}});
    areas.push_back(face_area(mesh, face));
  }
  PlateHinges found;
  const auto sides = sorted_sides(mesh.points.size(), [&](auto add) { for_each_face_side(mesh.faces, add); });
  for_each_edge(sides, [&](auto first, auto last) {
    if (last - first > 2) ++found.non_manifold;
    if (last - first != 2) return;
    const int from = first->forward ? first->low : first->high, to = first->forward ? first->high : first->low;
    const auto& X = mesh.points;
    const double length2 = squared_distance(X[from], X[to]);
    const Wing &c = wings[first[0].number], &d = wings[first[1].number];
    // If both faces are oriented consistently, wings of the same index in their faces are diagonally opposite.
    const int turned = first[0].forward == first[1].forward ? 1 : 0;
    const auto add = [&](int in_c, int in_d, double share) {
      const int wing_c = c.corner[in_c], wing_d = d.corner[in_d];
      const double both = (is_fixed(pinned, from, to, wing_c) ? 0 : area(X[from], X[to], X[wing_c])) +
                          (is_fixed(pinned, from, to, wing_d) ? 0 : area(X[from], X[to], X[wing_d]));
      found.list.push_back({from, to, wing_c, wing_d});
      found.softness.push_back(quotient(both / share, length2));
    };
    const bool quads = c.corner[0] != c.corner[1] && d.corner[0] != d.corner[1];
    if (c.corner[0] == c.corner[1] && d.corner[0] == d.corner[1]) return add(0, turned, 1);
    double crosswise = 1;
    if (quads) {
      double twist = 0, across = 0;
      for (const int f : {c.face, d.face}) {
        const double one = quotient(areas[f], std::sqrt(length2));
        twist += one * twist_about(length2, one * one) / 2, across += one / 2;
      }
      crosswise = std::min(1.0, rounded_to_one(quotient(across * twist, length2)));
    }
    for (int k = 0; k < 2; ++k) add(k, k ^ turned, 0.5 * crosswise);
    if (crosswise < 1)
      for (int k = 0; k < 2; ++k) add(k, k ^ turned ^ 1, 0.5 * (1 - crosswise));
  });
  return found;
}

FoldByCurvature fold_by_curvature(const Mesh& mesh, const std::array<int, 4>& hinge) {
  const auto& [from, to, c, d] = hinge;
  const auto& X = mesh.points;
  const Vec3 edge = minus(X[to], X[from]);
  const double length2 = dot(edge, edge), length = std::sqrt(length2);
  FoldByCurvature fold{0, 0, 0};  // sum over the wings of the lift above the edge, divided by the height
  double side = 1;
  for (const int wing : {c, d}) {
    const double height = quotient(2 * area(X[from], X[to], X[wing]), length);
    const double foot = quotient(dot(minus(X[wing], X[from]), edge), length);  // m along the edge
    if (!(height > 0)) return {0, 0, 0};
    fold.xx += foot * (foot - length) / (2 * height), fold.yy += height / 2, fold.xy += side * foot;
    side = -1;
  }
  return fold;
}

}  // namespace malha
