// SPDX-License-Identifier: Apache-2.0
// A cantilever of tetrahedra under its own weight, over refinement: compared with linear finite elements on the same
// tetrahedra, which this test solves by itself, and these with beam theory.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/Sparse>
#include <cmath>
#include <cstdio>
#include <map>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "malha/simulation.h"
#include "tests/constraints/cells_of_six.h"
#include "tests/scene_builders.h"

namespace malha {
namespace {

constexpr double span = 1, width = 0.2, E = 1e6, nu = 0.3, rho = 1000, g = 0.25;
/// Sag of the free end, m: Euler and Bernoulli's, and with shear (Timoshenko, Cowper's coefficient 5/6).
const double bernoulli = rho * g * 12 * std::pow(span, 4) / (8 * E * width * width);
const double timoshenko = bernoulli + rho * g * span * span / (2 * 5.0 / 6 * E / (2 * (1 + nu)));

TetBoxShape beam(int cells) { return {{span, width, width}, {5 * cells, cells, cells}}; }
bool held(const Vec3& X) { return X[0] < -span / 2 + 1e-6; }

/// The mean sag of the free end, m.
double tip(const std::vector<Vec3>& X, const std::vector<Vec3>& x) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < X.size(); ++i)
    if (X[i][0] > span / 2 - 1e-6) sum += X[i][1] - x[i][1], ++count;
  return sum / count;
}

double by_malha(int cells, int substeps, int iterations, double dt = 0.02, double poisson_ratio = nu,
                bool of_six = false) {
  const Shape shape =
      of_six ? Shape(cells_of_six({span, width, width}, {5 * cells, cells, cells})) : Shape(beam(cells));
  BodySpec body = malha::body("beam", shape, {neo_hookean(E, poisson_ratio)});
  body.mass.reset(), body.density = rho;
  body.pins = {BoxPin{{-span, -1, -1}, {-span / 2 + 1e-6, 1, 1}}};
  Scene scene = scene_of({body});
  scene.gravity = {0, -g, 0};
  scene.solver.dt = dt, scene.solver.substeps = substeps, scene.solver.iterations = iterations;
  // In float the displacement of a substep is lost in the rounding of positions.
  scene.solver.precision = Precision::Double;
  const Mesh rest = generate(beam(cells));
  const double mass = rho * span * width * width;
  scene.wind = Wind{{0, 0, 0}, 12 * mass / static_cast<double>(rest.points.size())};  // nearly critical damping
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 2 / dt; ++step) simulation.step();
  return tip(rest.points, simulation.positions());
}

/// Linear elasticity on tetrahedra of constant strain, with the loads of malha's lumped masses.
double by_finite_elements(int cells) {
  const Mesh mesh = generate(beam(cells));
  const int n = static_cast<int>(mesh.points.size());
  const double lame = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  std::vector<Eigen::Triplet<double>> entries;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    Eigen::Matrix4d corners;  // rows (1, x, y, z): the columns of the inverse are the shape functions
    for (int k = 0; k < 4; ++k) corners.row(k) << 1, mesh.points[t[k]][0], mesh.points[t[k]][1], mesh.points[t[k]][2];
    const Eigen::Matrix<double, 3, 4> slope = corners.inverse().bottomRows<3>();
    const double V = std::abs(corners.determinant()) / 6;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const Eigen::Vector3d A = slope.col(a), B = slope.col(b);
        const Eigen::Matrix3d K =
            V * (lame * A * B.transpose() + mu * B * A.transpose() + mu * A.dot(B) * Eigen::Matrix3d::Identity());
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            if (!held(mesh.points[t[a]]) && !held(mesh.points[t[b]]))
              entries.emplace_back(3 * t[a] + i, 3 * t[b] + j, K(i, j));
      }
  }
  for (int i = 0; i < n; ++i)
    if (held(mesh.points[i]))
      for (int k = 0; k < 3; ++k) entries.emplace_back(3 * i + k, 3 * i + k, 1);
  Eigen::SparseMatrix<double> K(3 * n, 3 * n);
  K.setFromTriplets(entries.begin(), entries.end());
  const std::vector<double> mass = masses_by_density(mesh, rho);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(3 * n);
  for (int i = 0; i < n; ++i)
    if (!held(mesh.points[i])) weight[3 * i + 1] = -g * mass[i];
  const Eigen::VectorXd moved = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(K).solve(weight);
  std::vector<Vec3> x = mesh.points;
  for (int i = 0; i < n; ++i) x[i][1] += moved[3 * i + 1];
  return tip(mesh.points, x);
}

TEST(BeamOfTetrahedra, BendsAsFiniteElementsOnTheSameTetrahedra) {
  // What is left is the error of one projection a substep, which falls with dt^2 over that of a shear wave's way
  // through a cell, and 1 % of large deflections.
  EXPECT_NEAR(by_malha(1, 10, 1) / by_finite_elements(1), 1, 0.03);
  EXPECT_NEAR(by_malha(2, 40, 1) / by_finite_elements(2), 1, 0.03);
  EXPECT_NEAR(by_malha(4, 80, 1) / by_finite_elements(4), 1, 0.03);
}

TEST(BeamOfTetrahedra, BendsAlikeWithIterationsInsteadOfSubsteps) {
  EXPECT_NEAR(by_malha(2, 5, 16) / by_finite_elements(2), 1, 0.05);
  EXPECT_GT(by_malha(4, 10, 1) / by_finite_elements(4), 1.5) << "too few of both: it is softer than its material";
}

/// The relative excess of the sag where a shear wave travels through so many cells, each of six tetrahedra, in a
/// substep.
double softened(int cells, double wave, int iterations) {
  const double cell = width / cells * std::cbrt(6.0 / 5), speed = std::sqrt(E / (3 * rho));
  constexpr int substeps = 10;
  return by_malha(cells, substeps, iterations, substeps * wave * cell / speed) / by_finite_elements(cells) - 1;
}

// These are figures of scenes/accuracy.md. They were also measured on beams of 1 to 4 cells across, Poisson's ratios of
// 0 to 0.45, and moved points.
TEST(BeamOfTetrahedra, SoftensWithTheCellsThatAWaveGetsThroughInASubstep) {
  for (const int cells : {1, 2, 3}) {
    std::map<double, double> share;
    for (const double wave : {0.1, 0.2, 0.3, 0.4, 0.8}) {
      share[wave] = softened(cells, wave, 1);
      std::printf("%d cells across, a wave through %.1f of them: sinks too far by %.0f %%\n", cells, wave,
                  100 * share[wave]);
    }
    EXPECT_NEAR(share[0.1], 0.01, 0.025) << cells;
    EXPECT_NEAR(share[0.2], 0.015, 0.045) << cells;
    EXPECT_NEAR(share[0.3], 0.13, 0.1) << cells;
    EXPECT_NEAR(share[0.4], 0.4, 0.3) << cells;
    EXPECT_GT(share[0.8], 1.0) << cells;
    EXPECT_NEAR(softened(cells, 0.4, 4), 0.03, 0.07) << cells << ": as 0.2 with one iteration";
    EXPECT_NEAR(softened(cells, 0.8, 16), 0.03, 0.07) << cells << ": as 0.2 with one iteration";
  }
}

// These are figures of scenes/accuracy.md; the test prints them.
TEST(BeamOfTetrahedra, OfSixACellSoftensWithPoissonsRatioToo) {
  for (const int cells : {1, 2})
    for (const double ratio : {0.0, 0.3, 0.4, 0.45, 0.48}) {
      constexpr int substeps = 10;
      const double unit = substeps * width / cells / std::sqrt(E / (3 * rho));  // s, a step of one cell a substep
      const double right = by_malha(cells, 2 * substeps, 1, 0.12 * unit, ratio, true);
      std::printf("six a cell, %d across, Poisson's ratio %.2f: sinks too far by", cells, ratio);
      for (const double wave : {0.1, 0.18, 0.25, 0.4}) {
        const double share = by_malha(cells, substeps, 1, wave * unit, ratio, true) / right - 1;
        std::printf(" %.0f %%", 100 * share);
        const double s = wave * wave * 2 * ratio / (1 - 2 * ratio), expected = s / (1 + s / 4);
        if (wave < 0.3) {
          EXPECT_NEAR(share, 1.1 * expected, 0.05 + 0.6 * expected) << cells << ", " << ratio << ", " << wave;
        }
      }
      std::printf("\n");
    }
}

TEST(BeamOfTetrahedra, LocksWhereCoarseAndComesToTheTheoryUnderRefinement) {
  std::map<int, double> share;
  for (const int cells : {1, 2, 4, 6}) {
    share[cells] = by_finite_elements(cells) / timoshenko;
    std::printf("%d cells across: %.3f of Timoshenko's, %.3f of Euler and Bernoulli's\n", cells, share[cells],
                share[cells] * timoshenko / bernoulli);
  }
  // Tetrahedra of constant strain are too stiff in bending, with the square of their size.
  EXPECT_NEAR(share[1], 0.34, 0.03);
  EXPECT_NEAR(share[2], 0.66, 0.03);
  EXPECT_NEAR(share[4], 0.87, 0.03);
  EXPECT_NEAR(share[6], 0.94, 0.03);
  EXPECT_NEAR(share[4] + (share[4] - share[2]) / 3, 0.96, 0.04) << "extrapolated to no size at all";
}

}  // namespace
}  // namespace malha
