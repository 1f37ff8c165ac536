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

/// The least of what a curvature of size 1 folds the hinges by, over the triangle's size, once the six are stretched so
/// that the triangle is equilateral; 0 where they lie on a conic, which stretching does not change. Equilateral
/// triangles have 1.07, of Delaunay's one in a hundred has less than 0.5, of diagonals at random one in 300 less than
/// 0.2.
double fixes_curvature(const std::vector<Vec3>& points, const std::array<int, 6>& of) {
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

/// What each triangle stands for, and what is connected with whole ones: those that are not `whole` hand on what of
/// their area their own hinges do not stand for, from the farthest inwards, in equal parts to their neighbours that are
/// a step nearer to a whole one.
struct StandFor {
  std::vector<double> area;
  std::vector<bool> connected;  // with a whole one
};
StandFor handed_on(std::vector<double> area, const std::vector<bool>& whole, const std::vector<int>& other) {
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
  StandFor found{std::move(area), std::vector<bool>(count)};
  for (int t = 0; t < count; ++t) found.connected[t] = away[t] >= 0;
  return found;
}

}  // namespace

WingedTriangles winged_triangles(const Mesh& mesh, const std::vector<bool>& held) {
  constexpr double least = 0.2;  // below, a fit would be 25 times as stiff as the plate against some folds
  // A clamp folds its hinges half as far as the sheet that goes on beyond it, mirrored: the energy is four times that
  // of the fit beside it.
  constexpr double kMirrored = 3;
  const std::vector<Triangle> all = triangles(mesh);
  WingedTriangles found;
  const std::vector<int> other = opposite_sides(mesh.points.size(), all, &found.crowded);
  const auto wing = [&](int side) { return other[side] < 0 ? -1 : all[other[side] / 3][(other[side] + 2) % 3]; };
  std::vector<double> area(all.size());  // of what can bend
  std::vector<bool> whole(all.size()), still(all.size()), bends(all.size());
  for (std::size_t t = 0; t < all.size(); ++t) {
    const int side = static_cast<int>(3 * t);
    // Side k runs from corner k to the next: across from the one before it.
    const std::array<int, 6> of{all[t][0], all[t][1], all[t][2], wing(side + 1), wing(side + 2), wing(side)};
    still[t] = held[all[t][0]] && held[all[t][1]] && held[all[t][2]];
    if (!still[t]) area[t] = area_of(mesh, all[t]);
    std::array<int, 6> sorted = of;
    std::sort(sorted.begin(), sorted.end());
    if (sorted[0] < 0 || std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) continue;
    if (fixes_curvature(mesh.points, of) < least) continue;
    whole[t] = true, bends[t] = !still[t];
    found.list.push_back(of);
  }
  const StandFor stands_for = handed_on(area, bends, other);
  for (std::size_t t = 0; t < all.size(); ++t) {
    if (!whole[t]) continue;
    double beside = 0;  // area
    for (int side = static_cast<int>(3 * t); side < static_cast<int>(3 * t + 3); ++side)
      if (other[side] >= 0) beside += area[other[side] / 3];
    found.softness.push_back(bends[t]     ? area[t] / stands_for.area[t]
                             : beside > 0 ? area_of(mesh, all[t]) / (kMirrored * beside)
                                          : 1);
  }
  const auto corner = [&](int side, int ahead) { return all[side / 3][(side + ahead) % 3]; };
  for (int side = 0; side < static_cast<int>(other.size()); ++side) {
    if (other[side] <= side || whole[side / 3] || whole[other[side] / 3]) continue;
    found.hinges.push_back({corner(side, 0), corner(side, 1), corner(side, 2), corner(other[side], 2)});
    const double both = area[side / 3] + area[other[side] / 3];
    const double length2 = squared_distance(mesh.points[corner(side, 0)], mesh.points[corner(side, 1)]);
    // Beside a whole one so that it has its share of the energy of a curvature, on average over its directions.
    found.hinge_softness.push_back(!(length2 > 0 && both > 0) ? 0
                                   : stands_for.connected[side / 3]
                                       ? fold_by_curvature(mesh, found.hinges.back()).most2() / both
                                       : both / length2);
  }
  return found;
}

}  // namespace malha
