// SPDX-License-Identifier: Apache-2.0
#include "host/model/isotropy.h"

#include <algorithm>
#include <cmath>

#include "host/mesh/edge_sides.h"
#include "host/mesh/vectors.h"
#include "host/model/material.h"

namespace malha {

namespace {

constexpr int kDirections = 12;  // in half a turn; a quartic of the angle has five coefficients

double angle_of(int direction) { return direction * std::acos(-1.0) / kDirections; }

/// Energies of strains or curvatures of norm 1 in all directions, summed for each vertex in a tangent frame of its own.
class VertexEnergies {
 public:
  explicit VertexEnergies(const Mesh& mesh) : mesh_(mesh), at_(mesh.points.size()) {
    std::vector<Vec3> normal(mesh.points.size(), Vec3{0, 0, 0});
    for (const Quad& face : mesh.faces) {
      const int corners = is_triangle(face) ? 3 : 4;
      const auto& X = mesh.points;
      const Vec3 twice = is_triangle(face) ? malha::normal(X[face[0]], X[face[1]], X[face[2]])
                                           : cross(minus(X[face[2]], X[face[0]]), minus(X[face[3]], X[face[1]]));
      for (int k = 0; k < corners; ++k) {
        // The faces may be oriented inconsistently.
        Vec3& n = normal[face[k]];
        const double sign = dot(n, twice) < 0 ? -1 : 1;
        n = {n[0] + sign * twice[0], n[1] + sign * twice[1], n[2] + sign * twice[2]};
        at_[face[k]].area += norm(twice) / 2 / corners;
      }
    }
    for (std::size_t i = 0; i < at_.size(); ++i) {
      const double size = norm(normal[i]);
      if (!(size > 0)) continue;
      At& at = at_[i];
      at.normal = {normal[i][0] / size, normal[i][1] / size, normal[i][2] / size};
      const Vec3 axis = std::abs(at.normal[0]) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
      at.x = cross(at.normal, axis);
      const double length = norm(at.x);
      for (double& a : at.x) a /= length;
      at.y = cross(at.normal, at.x);
      at.inside = true;
    }
    const auto sides = sorted_sides(mesh.points.size(), [&](auto add) { for_each_face_side(mesh.faces, add); });
    for_each_edge(sides, [&](auto first, auto last) {
      if (last - first != 2) at_[first->low].inside = at_[first->high].inside = false;
    });
  }

  double area(int i) const { return at_[i].area; }
  /// The angle of the direction from point a to point b in the frame of vertex i.
  double angle(int i, int a, int b) const {
    const Vec3 d = minus(mesh_.points[b], mesh_.points[a]);
    return std::atan2(dot(d, at_[i].y), dot(d, at_[i].x));
  }
  /// True if a wing lies to the left of the edge from a to b, seen against the normal of vertex i.
  bool to_the_left(int i, int a, int b, int wing) const {
    return dot(normal(mesh_.points[a], mesh_.points[b], mesh_.points[wing]), at_[i].normal) > 0;
  }
  /// Adds energy(angle), the energy of a strain along the direction at this angle.
  template <class Energy>
  void add(int i, Energy energy) {
    for (int k = 0; k < kDirections; ++k) at_[i].energy[k] += energy(angle_of(k));
  }
  template <class Energy>
  void add_reference(int i, Energy energy) {
    for (int k = 0; k < kDirections; ++k) at_[i].reference[k] += energy(angle_of(k));
  }

  Isotropy mean() const {
    double space = 0, least = 0, most = 0;
    for (const At& at : at_) {
      if (!at.inside) continue;
      double low = INFINITY, high = 0;
      for (int k = 0; k < kDirections; ++k) {
        const double share = at.energy[k] / at.reference[k];
        low = std::min(low, share), high = std::max(high, share);
      }
      if (!(high < INFINITY)) continue;
      space += at.area, least += at.area * low, most += at.area * high;
    }
    return space > 0 ? Isotropy{least / space, most / space} : Isotropy{};
  }

 private:
  struct At {
    Vec3 normal{}, x{}, y{};
    double area = 0;
    bool inside = false;
    std::array<double, kDirections> energy{}, reference{};
  };
  const Mesh& mesh_;
  std::vector<At> at_;
};

double fourth(double a) { return a * a * a * a; }

}  // namespace

Isotropy isotropy_of_springs(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<double>& stiffness,
                             double Y, double G) {
  VertexEnergies energies(mesh);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto& [a, b] = edges[e];
    const double energy = stiffness[e] * squared_distance(mesh.points[a], mesh.points[b]) / 2;
    for (const int i : {a, b}) {
      const double along = energies.angle(i, a, b);
      energies.add(i, [&](double angle) { return energy * fourth(std::cos(angle - along)); });
    }
  }
  for (const Quad& face : mesh.faces) {
    const int corners = is_triangle(face) ? 3 : 4;
    const double share = face_area(mesh, face) / corners;
    for (int k = 0; k < corners; ++k) {
      const int i = face[k];
      if (corners == 3) {
        energies.add_reference(i, [&](double) { return share * Y * 9 / 8; });
        continue;
      }
      // The axes of a square: 45 degrees before the mean direction of two sides.
      const double one = energies.angle(i, face[0], face[1]), other = energies.angle(i, face[1], face[2]);
      const double along = (one + other) / 2 - std::acos(-1.0) / 4;
      energies.add_reference(i, [&](double angle) {
        const double c2 = std::pow(std::cos(angle - along), 2), s2 = 1 - c2;
        return share * ((Y + G) * (c2 * c2 + s2 * s2) + 6 * G * c2 * s2);
      });
    }
  }
  return energies.mean();
}

Isotropy isotropy_of_hinges(const Mesh& mesh, const std::vector<std::array<int, 4>>& hinges,
                            const std::vector<double>& softness) {
  VertexEnergies energies(mesh);
  for (std::size_t h = 0; h < hinges.size(); ++h) {
    if (!(softness[h] > 0)) continue;
    const FoldByCurvature fold = fold_by_curvature(mesh, hinges[h]);
    const auto& [from, to, wing, other] = hinges[h];
    for (const int i : {from, to}) {
      const double along = energies.angle(i, from, to), side = energies.to_the_left(i, from, to, wing) ? 1 : -1;
      energies.add(i, [&](double angle) {
        const double c = std::cos(angle - along), s = side * std::sin(angle - along);
        const double folded = fold.xx * c * c + fold.yy * s * s + fold.xy * c * s;
        return folded * folded / softness[h] / 2;
      });
    }
  }
  for (int i = 0; i < static_cast<int>(mesh.points.size()); ++i)
    energies.add_reference(i, [&](double) { return energies.area(i); });
  return energies.mean();
}

}  // namespace malha
