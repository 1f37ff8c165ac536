// SPDX-License-Identifier: Apache-2.0
// The angular velocity of a body as a whole, against rotations that are known.
#include "kernels/forces/angular_velocity.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

using Points3 = std::vector<Vector3<double>>;

/// Momenta of points of 1 kg about the origin, which rotate with omega.
SpinSum spin_of(const Points3& points, const Vector3<double>& omega) {
  SpinSum sum;
  for (const Vector3<double>& r : points) {
    const Vector3<double> L = cross(r, cross(omega, r));
    sum += SpinSum{
        {L.x, L.y, L.z},
        {r.y * r.y + r.z * r.z, r.x * r.x + r.z * r.z, r.x * r.x + r.y * r.y, -r.x * r.y, -r.x * r.z, -r.y * r.z}};
  }
  return sum;
}

/// `along`: the columns are the directions in which the points lie.
Points3 cloud(Random& random, const Eigen::Matrix3d& along) {
  Points3 points;
  for (int i = 0; i < 20; ++i) {
    const Vector3<double> a = random.in_cube();
    const Eigen::Vector3d r = along * Eigen::Vector3d(a.x, a.y, a.z);
    points.push_back({r[0], r[1], r[2]});
  }
  return points;
}

Eigen::Matrix3d any_rotation(Random& random) {
  const Vector3<double> a = random.in_cube(3);
  const Eigen::Vector3d axis(a.x, a.y, a.z);
  return Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
}

// Inertias differ by up to (1 / 0.01)^2, which multiplies the rounding (1e-16) of some tens of numbers.
TEST(AngularVelocity, IsThatWithWhichAllTurn) {
  Random random(1);
  for (const double flat : {1.0, 0.1, 0.01}) {
    for (int n = 0; n < 200; ++n) {
      const Eigen::Matrix3d turn = any_rotation(random);
      const Vector3<double> omega = random.in_cube(5);
      const Points3 points = cloud(random, turn * Eigen::DiagonalMatrix<double, 3>(1, flat, flat));
      EXPECT_LT(norm(angular_velocity(spin_of(points, omega)) - omega), 1e-10) << flat << ", " << n;
    }
  }
}

TEST(AngularVelocity, IsThatOfABoxAlongTheAxes) {
  const Points3 box{{1, 2, 3}, {-1, 2, 3}, {1, -2, 3}, {1, 2, -3}, {-1, -2, 3}, {-1, 2, -3}, {1, -2, -3}, {-1, -2, -3}};
  const Vector3<double> omega{0.3, -7, 2};
  EXPECT_LT(norm(angular_velocity(spin_of(box, omega)) - omega), 1e-14);
  // the inertia about any axis is the same
  const Points3 round{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  EXPECT_LT(norm(angular_velocity(spin_of(round, omega)) - omega), 1e-14);
}

TEST(AngularVelocity, HasNothingAlongALineOnWhichAllLie) {
  Random random(2);
  for (int n = 0; n < 200; ++n) {
    const Eigen::Matrix3d turn = any_rotation(random);
    const Vector3<double> line{turn(0, 0), turn(1, 0), turn(2, 0)}, omega = random.in_cube(5);
    const Points3 points = cloud(random, turn * Eigen::DiagonalMatrix<double, 3>(1, 0, 0));
    const Vector3<double> across = omega - line * dot(line, omega);
    EXPECT_LT(norm(angular_velocity(spin_of(points, omega)) - across), 1e-13) << n;
  }
  EXPECT_EQ(norm(angular_velocity(SpinSum{{1, 2, 3}, {}})), 0) << "of one point";
}

/// The equation is solved also where L is not that of any motion.
TEST(AngularVelocity, SolvesForAnyMomentum) {
  Random random(3);
  for (int n = 0; n < 200; ++n) {
    const SpinSum shape = spin_of(cloud(random, any_rotation(random)), {1, 1, 1});
    const Vector3<double> L = random.in_cube(9);
    SpinSum spin = shape;
    spin.L[0] = L.x, spin.L[1] = L.y, spin.L[2] = L.z;
    const double* I = spin.I;
    Eigen::Matrix3d inertia;
    inertia << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
    const Eigen::Vector3d omega = inertia.fullPivLu().solve(Eigen::Vector3d(L.x, L.y, L.z));
    EXPECT_LT(norm(angular_velocity(spin) - Vector3<double>{omega[0], omega[1], omega[2]}), 1e-12) << n;
  }
}

}  // namespace
}  // namespace malha
