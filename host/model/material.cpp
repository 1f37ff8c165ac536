#include "host/model/material.h"

#include <cmath>

#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

/// Nothing that has no length can bend or stretch.
double over(double a, double length2) { return length2 > 0 ? a / length2 : 0; }

/// A quad's: the mean of its two splits.
double face_area(const Mesh& mesh, const Quad& face) {
  const auto of = [&](int i, int j, int k) {
    return area(mesh.points[face[i]], mesh.points[face[j]], mesh.points[face[k]]);
  };
  return is_triangle(face) ? of(0, 1, 2) : 0.5 * (of(0, 1, 2) + of(0, 2, 3) + of(1, 2, 3) + of(1, 3, 0));
}

}  // namespace

std::vector<double> edge_softness(const Mesh& mesh, const std::vector<Edge>& edges) {
  std::vector<int> face_of;  // of each side, in the order of visit_face_sides
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    face_of.insert(face_of.end(), is_triangle(mesh.faces[f]) ? 3 : 4, static_cast<int>(f));
  const int sides = static_cast<int>(face_of.size());
  // The edges come after the sides, so that every group of equals holds the faces of an edge and its number.
  const auto all = sorted_sides(mesh.points.size(), [&](auto add) {
    visit_face_sides(mesh.faces, add);
    for (const auto& [from, to] : edges) add(from, to);
  });
  std::vector<double> softness(edges.size());
  for_each_edge(all, [&](auto first, auto last) {
    const double length2 = squared_distance(mesh.points[first->low], mesh.points[first->high]);
    double share = 0;
    for (auto side = first; side != last; ++side)
      if (side->number < sides) {
        const Quad& face = mesh.faces[face_of[side->number]];
        share += face_area(mesh, face) * (is_triangle(face) ? 1 : 0.5);
      }
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
          over(2 * face_area(mesh, face), squared_distance(mesh.points[face[k]], mesh.points[face[k + 2]])));
  }
  return softness;
}

std::vector<double> hinge_softness(const Mesh& mesh, const std::vector<std::array<int, 4>>& hinges,
                                   const std::vector<double>& shares) {
  std::vector<double> softness;
  softness.reserve(hinges.size());
  for (std::size_t h = 0; h < hinges.size(); ++h) {
    const auto& [a, b, c, d] = hinges[h];
    const auto& X = mesh.points;
    const double both = (area(X[a], X[b], X[c]) + area(X[a], X[b], X[d])) / shares[h];
    softness.push_back(over(both, squared_distance(X[a], X[b])));
  }
  return softness;
}

}  // namespace malha
