// SPDX-License-Identifier: Apache-2.0
#include "host/model/material.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "kernels/constraints/plate.h"
#include "kernels/projection/rest.h"

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

/// True if all corners of a triangle are pinned, so that it cannot bend.
bool is_fixed(const std::vector<bool>& pinned, int a, int b, int c) { return pinned[a] && pinned[b] && pinned[c]; }

/// The smallest fold of the hinges by a curvature of norm 1, over the triangle's size, after an affine map that makes
/// the triangle equilateral. It is 0 if the six points lie on a conic, which an affine map preserves. Equilateral
/// triangles have 1.07; of Delaunay triangles one in a hundred has less than 0.5, of random diagonals one in 300 less
/// than 0.2.
double curvature_condition(const RestShape& shape, const std::array<int, 6>& of) {
  Vec3 rest[6];
  shape.corners(Element::WingedTriangles, of.data(), rest);
  constexpr int in_order[6] = {0, 1, 2, 3, 4, 5};
  Vector3<double> X[6];
  corners<Plate>(rest, in_order, X);
  double u[6], v[6], a[3][3], area = 0;
  Plate::unfold(X, u, v);
  if (!(u[1] > 0 && v[2] > 0)) return 0;
  for (int j = 0; j < 6; ++j) {
    const double up = v[j] / v[2], along = (u[j] - u[2] * up) / u[1];
    X[j] = {along + 0.5 * up, std::sqrt(0.75) * up, 0};
  }
  Plate::folds_by_curvature(X, u, v, a, area);
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) matrix.row(i) << a[i][0], a[i][1], a[i][2] / std::sqrt(2.0);
  return Eigen::JacobiSVD<Eigen::Matrix3d>(matrix).singularValues()[2] / std::sqrt(area);
}

double area_of(const RestShape& shape, const Triangle& t) {
  Vec3 X[3];
  shape.corners(Element::Triangles, t.data(), X);
  return norm(normal(X[0], X[1], X[2])) / 2;
}

/// The area that each triangle represents.
struct RepresentedArea {
  std::vector<double> area;
  std::vector<bool> connected;  // with a `whole` triangle
};
/// Distributes the area of triangles that are not `whole`, as far as their own hinges do not represent it: from the
/// farthest inwards, in equal parts to the neighbours that are one step nearer to a whole triangle.
RepresentedArea distribute_area(std::vector<double> area, const std::vector<bool>& whole,
                                const std::vector<int>& other) {
  const int count = static_cast<int>(area.size());
  std::vector<int> away(count, -1), own_hinges(count), order;
  for (int t = 0; t < count; ++t)
    if (whole[t]) away[t] = 0, order.push_back(t);
  for (std::size_t k = 0; k < order.size(); ++k)
    for (int side = 3 * order[k]; side < 3 * order[k] + 3; ++side)
      if (const int next = other[side] / 3; other[side] >= 0 && away[next] < 0)
        away[next] = away[order[k]] + 1, order.push_back(next);
  for (int t = 0; t < count; ++t)
    for (int side = 3 * t; side < 3 * t + 3 && !whole[t]; ++side)
      if (other[side] >= 0 && !whole[other[side] / 3]) own_hinges[t] += 1;
  for (int t = 0; t < count; ++t) area[t] *= 1 - own_hinges[t] / 3.0;
  for (auto t = order.rbegin(); t != order.rend() && away[*t] > 0; ++t) {
    std::vector<int> nearer;
    for (int side = 3 * *t; side < 3 * *t + 3; ++side)
      if (other[side] >= 0 && away[other[side] / 3] == away[*t] - 1) nearer.push_back(other[side] / 3);
    for (const int to : nearer) area[to] += area[*t] / static_cast<double>(nearer.size());
  }
  RepresentedArea found{std::move(area), std::vector<bool>(count)};
  for (int t = 0; t < count; ++t) found.connected[t] = away[t] >= 0;
  return found;
}

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

double face_area(const Mesh& mesh, const Quad& face) {
  const auto of = [&](int i, int j, int k) {
    return area(mesh.points[face[i]], mesh.points[face[j]], mesh.points[face[k]]);
  };
  return is_triangle(face) ? of(0, 1, 2) : 0.5 * (of(0, 1, 2) + of(0, 2, 3) + of(1, 2, 3) + of(1, 3, 0));
}

std::vector<double> edge_softness(const RestShape& shape, const std::vector<Edge>& edges, double shear) {
  const Mesh &mesh = shape.mesh(), &places = shape.places();
  std::vector<int> face_of, number_in_face;  // of each side, in the order of for_each_face_side
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (int k = 0; k < (is_triangle(mesh.faces[f]) ? 3 : 4); ++k)
      face_of.push_back(static_cast<int>(f)), number_in_face.push_back(k);
  const int sides = static_cast<int>(face_of.size());
  // The share of the area for a side. The diagonals act along the side too, with (side / other side)^2 times their
  // shear stiffness, which is subtracted.
  const auto part_of = [&](int side) {
    const Quad& face = places.faces[face_of[side]];
    if (is_triangle(face)) return 1.0;
    const double aspect2 = squared_aspect(places, face);
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
    const double length2 = shape.squared_length(first->low, first->high);
    double share = 0;
    for (auto side = first; side != last; ++side)
      if (side->number < sides) share += face_area(places, places.faces[face_of[side->number]]) * part_of(side->number);
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

PlateHinges plate_hinges(const RestShape& shape, const std::vector<bool>& pinned) {
  const Mesh &mesh = shape.mesh(), &places = shape.places();
  std::vector<std::array<int, 2>> wings;  // of each side, the corners after it and before it
  for (const Quad& face : mesh.faces) {
    const int corners = is_triangle(face) ? 3 : 4;
    for (int k = 0; k < corners; ++k) wings.push_back({face[(k + 2) % corners], face[(k + corners - 1) % corners]});
  }
  PlateHinges found;
  const auto sides = sorted_sides(mesh.points.size(), [&](auto add) { for_each_face_side(mesh.faces, add); });
  for (const int k : {0, 1})
    for_each_edge(sides, [&](auto first, auto last) {
      if (last - first > 2 && k == 0) ++found.non_manifold;
      if (last - first != 2) return;
      const int from = first->forward ? first->low : first->high, to = first->forward ? first->high : first->low;
      const auto &c = wings[first[0].number], &d = wings[first[1].number];
      // If both faces are oriented consistently, wings of different index in their faces are on the same side.
      const int turned = first[0].forward == first[1].forward ? 0 : 1;
      const int count = c[0] == c[1] && d[0] == d[1] ? 1 : 2;
      if (k >= count) return;
      const int wing_c = c[k], wing_d = d[k ^ turned];
      const double both = (is_fixed(pinned, from, to, wing_c) ? 0 : shape.area(from, to, wing_c)) +
                          (is_fixed(pinned, from, to, wing_d) ? 0 : shape.area(from, to, wing_d));
      found.list.push_back({from, to, wing_c, wing_d});
      found.softness.push_back(quotient(count * both, shape.squared_length(from, to)));
    });
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Quad &face = mesh.faces[f], &at = places.faces[f];
    for (int k = 0; k < 2 && !is_triangle(face); ++k) {
      found.list.push_back({face[k], face[k + 2], face[k + 1], face[(k + 3) % 4]});
      found.softness.push_back(
          quotient(squared_distance(places.points[at[k]], places.points[at[k + 2]]), face_area(places, at)));
    }
  }
  return found;
}

FoldByCurvature fold_by_curvature(const RestShape& shape, const std::array<int, 4>& hinge) {
  constexpr int from = 0, to = 1;
  Vec3 X[4];
  shape.corners(Element::Hinges, hinge.data(), X);
  const Vec3 edge = minus(X[to], X[from]);
  const double length2 = dot(edge, edge), length = std::sqrt(length2);
  FoldByCurvature fold{0, 0, 0};  // sum over the wings of the lift above the edge, divided by the height
  double side = 1;
  for (const int wing : {2, 3}) {
    const double height = quotient(2 * area(X[from], X[to], X[wing]), length);
    const double foot = quotient(dot(minus(X[wing], X[from]), edge), length);  // m along the edge
    if (!(height > 0)) return {0, 0, 0};
    fold.xx += foot * (foot - length) / (2 * height), fold.yy += height / 2, fold.xy += side * foot;
    side = -1;
  }
  return fold;
}

std::optional<Orthotropic> orthotropic_of(const ConstraintSpec& spec) {
  if (!spec.orthotropy) return {};
  const auto& [across, shear, along] = *spec.orthotropy;
  const double first = spec.rigidity ? *spec.rigidity : spec.young_modulus.value(), mean = std::sqrt(first * across);
  const double nu = spec.parameter * std::sqrt(across / first);
  const double huber = spec.rigidity ? mean * (1 - nu) / 2 : mean / (2 * (1 + nu));
  const Vec3 x = along.value_or(Vec3{1, 0, 0});
  return Orthotropic{spec.parameter, across / first, shear.value_or(huber) / first, {x[0], x[1], x[2]}};
}

double rigidity_across(const RestShape& shape, const std::array<int, 4>& hinge, const Orthotropic& material) {
  Vec3 X[4];
  shape.corners(Element::Hinges, hinge.data(), X);
  const auto vector = [](const Vec3& a) { return Vector3<double>{a[0], a[1], a[2]}; };
  const Vector3<double> edge = vector(minus(X[1], X[0])), n = vector(normal(X[0], X[1], X[2]));
  return material.rigidity(material.cosine2(n, cross(n, edge)));
}

WingedTriangles winged_triangles(const RestShape& shape, const std::vector<bool>& pinned) {
  const Mesh& mesh = shape.mesh();
  constexpr double least = 0.2;  // below this a fit would be 25 times as stiff as the plate against some folds
  // A clamp folds its hinges half as far as a sheet that continues as its mirror image: the energy must be four times
  // that of the adjacent fit.
  constexpr double kMirrored = 3;
  const std::vector<Triangle> all = triangles(mesh);
  WingedTriangles found;
  const std::vector<int> other = opposite_sides(mesh.points.size(), all, &found.non_manifold);
  const auto wing = [&](int side) { return other[side] < 0 ? -1 : all[other[side] / 3][(other[side] + 2) % 3]; };
  std::vector<double> area(all.size());  // of triangles that can bend, otherwise 0
  std::vector<bool> whole(all.size()), fixed(all.size()), bends(all.size());
  for (std::size_t t = 0; t < all.size(); ++t) {
    const int side = static_cast<int>(3 * t);
    // Side k runs from corner k to the next, and is across from the corner before it.
    const std::array<int, 6> of{all[t][0], all[t][1], all[t][2], wing(side + 1), wing(side + 2), wing(side)};
    fixed[t] = pinned[all[t][0]] && pinned[all[t][1]] && pinned[all[t][2]];
    if (!fixed[t]) area[t] = area_of(shape, all[t]);
    std::array<int, 6> sorted = of;
    std::ranges::sort(sorted);
    if (sorted[0] < 0 || std::ranges::adjacent_find(sorted) != sorted.end()) continue;
    if (curvature_condition(shape, of) < least) continue;
    whole[t] = true, bends[t] = !fixed[t];
    found.list.push_back(of);
  }
  const RepresentedArea represented = distribute_area(area, bends, other);
  for (std::size_t t = 0; t < all.size(); ++t) {
    if (!whole[t]) continue;
    double beside = 0;  // area of the neighbours that bend
    for (int side = static_cast<int>(3 * t); side < static_cast<int>(3 * t + 3); ++side)
      if (other[side] >= 0) beside += area[other[side] / 3];
    found.softness.push_back(bends[t]     ? area[t] / represented.area[t]
                             : beside > 0 ? area_of(shape, all[t]) / (kMirrored * beside)
                                          : 1);
  }
  const auto corner = [&](int side, int ahead) { return all[side / 3][(side + ahead) % 3]; };
  for (int side = 0; side < static_cast<int>(other.size()); ++side) {
    if (other[side] <= side || whole[side / 3] || whole[other[side] / 3]) continue;
    found.hinges.push_back({corner(side, 0), corner(side, 1), corner(side, 2), corner(other[side], 2)});
    const double both = area[side / 3] + area[other[side] / 3];
    const double length2 = shape.squared_length(corner(side, 0), corner(side, 1));
    // A hinge connected with a winged triangle gets its share of the energy of a curvature, as a mean over all
    // directions.
    found.hinge_softness.push_back(!(length2 > 0 && both > 0) ? 0
                                   : represented.connected[side / 3]
                                       ? fold_by_curvature(shape, found.hinges.back()).most2() / both
                                       : both / length2);
  }
  return found;
}

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
