// SPDX-License-Identifier: Apache-2.0
#include "host/model/winged_triangles.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/model/material.h"
#include "kernels/constraints/plate.h"
#include "kernels/projection/rest.h"

namespace malha {

namespace {

/// The smallest fold of the hinges by a curvature of norm 1, over the triangle's size, after an affine map that makes
/// the triangle equilateral. It is 0 if the six points lie on a conic, which an affine map preserves. Equilateral
/// triangles have 1.07; of Delaunay triangles one in a hundred has less than 0.5, of random diagonals one in 300 less
/// than 0.2.
double curvature_condition(const std::vector<Vec3>& points, const std::array<int, 6>& of) {
  Vector3<double> X[6];
  corners<Plate>(points.data(), of.data(), X);
  double u[6], v[6], a[3][3], area = 0;
  Plate::unfold(X, u, v);
  if (!(u[1] > 0 && v[2] > 0)) return 0;
  for (int j = 0; j < 6; ++j) {
    const double up = v[j] / v[2], along = (u[j] - u[2] * up) / u[1];
    X[j] = {along + 0.5 * up, std::sqrt(0.75) * up, 0};
  }
  Plate::folds_by_curvature(X, a, area);
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) matrix.row(i) << a[i][0], a[i][1], a[i][2] / std::sqrt(2.0);
  return Eigen::JacobiSVD<Eigen::Matrix3d>(matrix).singularValues()[2] / std::sqrt(area);
}

double area_of(const Mesh& mesh, const Triangle& t) {
  const auto from_first = [&](int k) { return minus(mesh.points[t[k]], mesh.points[t[0]]); };
  return norm(cross(from_first(1), from_first(2))) / 2;
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

}  // namespace

WingedTriangles winged_triangles(const Mesh& mesh, const std::vector<bool>& pinned) {
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
    if (!fixed[t]) area[t] = area_of(mesh, all[t]);
    std::array<int, 6> sorted = of;
    std::sort(sorted.begin(), sorted.end());
    if (sorted[0] < 0 || std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) continue;
    if (curvature_condition(mesh.points, of) < least) continue;
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
                             : beside > 0 ? area_of(mesh, all[t]) / (kMirrored * beside)
                                          : 1);
  }
  const auto corner = [&](int side, int ahead) { return all[side / 3][(side + ahead) % 3]; };
  for (int side = 0; side < static_cast<int>(other.size()); ++side) {
    if (other[side] <= side || whole[side / 3] || whole[other[side] / 3]) continue;
    found.hinges.push_back({corner(side, 0), corner(side, 1), corner(side, 2), corner(other[side], 2)});
    const double both = area[side / 3] + area[other[side] / 3];
    const double length2 = squared_distance(mesh.points[corner(side, 0)], mesh.points[corner(side, 1)]);
    // A hinge connected with a winged triangle gets its share of the energy of a curvature, as a mean over all
    // directions.
    found.hinge_softness.push_back(!(length2 > 0 && both > 0) ? 0
                                   : represented.connected[side / 3]
                                       ? fold_by_curvature(mesh, found.hinges.back()).most2() / both
                                       : both / length2);
  }
  return found;
}

}  // namespace malha
