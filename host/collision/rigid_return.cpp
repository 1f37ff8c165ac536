#include "host/collision/rigid_return.h"

#include <Eigen/Dense>

namespace malha {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d mean(const double (&sum)[3], double mass) { return Vector3d(sum[0], sum[1], sum[2]) / mass; }

/// Sum of m p_i x_j about the means.
Matrix3d about_means(const RigidSums& sums) {
  Matrix3d spread;
  const Vector3d x = mean(sums.x, sums.mass), p = mean(sums.p, sums.mass);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) spread(i, j) = sums.xp[3 * j + i] - sums.mass * p[i] * x[j];
  return spread;
}

/// Sum of m x x p, which is that of m p x (p - x): the angular momentum times h.
Vector3d spin_of(const Matrix3d& spread) {
  return {spread(2, 1) - spread(1, 2), spread(0, 2) - spread(2, 0), spread(1, 0) - spread(0, 1)};
}

Vec3 to_vec(const Vector3d& a) { return {a[0], a[1], a[2]}; }

}  // namespace

RigidMove rigid_return(const RigidSums& before, const RigidSums& after) {
  constexpr double kMostTurn = 0.5;
  RigidMove move;
  if (!(after.mass > 0)) return move;
  const Matrix3d held = about_means(after);
  const Vector3d wanted = spin_of(about_means(before));
  Matrix3d turn = Matrix3d::Identity();
  for (int newton = 0; newton < 4; ++newton) {
    const Matrix3d now = turn * held;
    const Matrix3d by_turn = now.trace() * Matrix3d::Identity() - now;  // of the spin, by a small turn
    const Vector3d more = by_turn.completeOrthogonalDecomposition().solve(wanted - spin_of(now));
    if (!(more.norm() > 0)) break;
    turn = Eigen::AngleAxisd(more.norm(), more.normalized()).toRotationMatrix() * turn;
  }
  if (!turn.allFinite() || !(Eigen::AngleAxisd(turn).angle() < kMostTurn)) turn = Matrix3d::Identity();
  move.from = to_vec(mean(after.p, after.mass)), move.to = to_vec(mean(before.p, before.mass));
  for (int k = 0; k < 3; ++k) move.turn[k] = to_vec(turn.row(k).transpose());
  move.moves = move.from != move.to || turn != Matrix3d::Identity();
  return move;
}

}  // namespace malha
