// SPDX-License-Identifier: Apache-2.0
// The membrane: its energy against plane stress in principal stretches, its steps against backward Euler, and its
// robustness from any start.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "host/measure/measure.h"
#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "tests/constraints/uneven_sheet.h"
#include "tests/filter/filter_reference.h"
#include "tests/projection/one_constraint.h"

namespace malha {
namespace {

double elastic_at(const Model& model, const std::vector<Vec3>& x) {
  Measures measures;
  measure_constraints(Serial{}, model, x, measures);
  return measures.elastic;
}

/// Energy density of plane stress in the principal stretches of F, J/m^2.
double plane_stress(const Eigen::Matrix<double, 3, 2>& F, double Y, double nu) {
  const Eigen::Vector2d e = F.jacobiSvd().singularValues() - Eigen::Vector2d(1, 1);
  return Y / (1 - nu * nu) / 2 * (e.squaredNorm() + 2 * nu * e[0] * e[1]);
}

TEST(Membrane, StoresTheEnergyOfPlaneStressOnAnyTriangulation) {
  const TemporaryFolder folder;
  Random random(1);
  const double Y = 30;
  for (const bool even : {false, true})
    for (const double nu : {0.0, 0.3, 0.95}) {
      BodySpec body;
      body.name = "sheet", body.mass = 1, body.constraints = {membrane(Y, nu)};
      body.shape = GridShape{{2, 0.5}, {8, 3}};  // quads, in x and z
      if (!even) body.shape = written(folder, uneven_sheet(2, 0.5, 8, 3, 2));
      Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60);
      const Model by_pbd = build_model(scene);
      scene.solver.type = "desbrun";
      const Model by_desbrun = build_model(scene);
      for (int k = 0; k < 20; ++k) {
        Eigen::Matrix<double, 3, 2> F;
        for (int i = 0; i < 6; ++i) F.data()[i] = random(-1.5, 1.5);
        const double expected = 2 * 0.5 * plane_stress(F, Y, nu);
        for (const Model* model : {&by_pbd, &by_desbrun}) {
          std::vector<Vec3> x;
          for (const Vec3& X : model->x) {
            const Eigen::Vector3d at = F * Eigen::Vector2d(X[0], even ? X[2] : X[1]);
            x.push_back({at[0], at[1], at[2]});
          }
          EXPECT_NEAR(elastic_at(*model, x) / expected, 1, 1e-12) << nu;
        }
      }
      // In shear it is that of the modulus Y / (2 (1 + nu)): G gamma^2 / 2, to the second order of gamma.
      std::vector<Vec3> x = by_pbd.x;
      const double gamma = 1e-4;
      for (Vec3& at : x) at[0] += gamma * (even ? at[2] : at[1]);
      EXPECT_NEAR(elastic_at(by_pbd, x) / (2 * 0.5 * Y / (2 * (1 + nu)) * gamma * gamma / 2), 1, 1e-6) << nu;
    }
}

TEST(Membrane, ComesToTheBalanceOfItsThreeForces) {
  Random random(2);
  for (const double alpha : {1e-6, 1e-2, 1.0})
    for (const Corners<Membrane>& at : configurations<Membrane>(100, 17)) {
      Corners<Membrane> near = at;
      for (auto& a : near) a = a + random.in_cube(0.05);
      OneConstraint<Membrane, double> one(near, unequal_masses<Membrane>(random), rest_of<Membrane>(at, 0.3));
      for (int k = 0; k < 50; ++k) one.project<Update::Compliant>(0, alpha);
      const double forces = std::hypot(one.lambda[0], one.lambda[kSlotPack], one.lambda[2 * kSlotPack]);
      EXPECT_GT(forces, 0);
      EXPECT_NEAR(one.C(), alpha * forces, 1e-12 + 1e-9 * one.C()) << alpha;
    }
}

TEST(Membrane, GainsNoEnergyByAProjectionHoweverThinCrushedAndUnequal) {
  Random random(3);
  double most = 0;
  for (const double height : {1.0, 0.1, 0.02})
    for (const double alpha : {1e-4, 1e-2, 1.0})
      for (int start = 0; start < 2000; ++start) {
        const Vector3<double> X[3] = {{0, 0, 0}, {1, 0, 0}, {random(0, 1), height, 0}};
        double rest[5], w[3], sum[3] = {0, 0, 0};
        Membrane::rest(X, 0.3, rest);
        Vector3<double> from[3], p[3], move[3];
        for (auto& a : from) a = random.in_cube(start % 2 ? 1 : 0.2);
        for (double& a : w) a = std::pow(10, random(-2, 2));
        std::copy(from, from + 3, p);
        const double at_first = Membrane::energy(p, rest) / alpha;
        for (int k = 0; k < 30; ++k) {
          Membrane::step(p, from, w, rest, true, alpha, 1.0, sum, move);
          // The objective that a substep of backward Euler minimises, times the square of its duration.
          double now = 0;
          for (int j = 0; j < 3; ++j) {
            p[j] = p[j] + move[j] * w[j];
            now += dot(p[j] - from[j], p[j] - from[j]) / (2 * w[j]);
          }
          most = std::max(most, (now + Membrane::energy(p, rest) / alpha) / at_first);
        }
      }
  EXPECT_LT(most, 1.7) << "a thousand, of steps that go as far as their gradients tell; 1.125, of directions at p";
}

/// A turning, strained sheet, free or hung by two corners, and the residual of backward Euler after a step.
TEST(Membrane, ByRefinedDesbrunIsBackwardEulerOfItsEnergy) {
  const TemporaryFolder folder;
  const Mesh mesh = uneven_sheet(0.5, 0.5, 4, 4, 6);
  const double Y = 40, nu = 0.4;
  for (const bool pinned : {false, true}) {
    BodySpec body;
    body.name = "sheet", body.mass = 0.5, body.spin = {3, -2, 4}, body.velocity = {0.5, 1, 0};
    body.shape = written(folder, mesh), body.constraints = {membrane(Y, nu)};
    if (pinned) body.pins = {ListPin{{0, 4}}};
    Scene scene = desbrun_scene({body}, 1);
    scene.solver.desbrun.corrector = Corrector::Off;
    const double dt = scene.solver.dt;
    const Model model = build_model(scene);
    std::vector<double> mass(mesh.points.size());
    for (int i = 0; i < model.count(); ++i) mass[model.user_index[i]] = model.w[i] > 0 ? 1 / model.w[i] : 0;
    const auto energy = [&](const std::vector<Vec3>& x, const Quad& t) {
      return area_of(mesh.points, t) * plane_stress(gradient_of(mesh.points, x, t), Y, nu);
    };
    // |M (x' - x - dt v - dt^2 g) + dt^2 dU/dx'|, over what it is where x' = x + dt v: differences err by 1e-9.
    const auto residual = [&](const std::vector<Vec3>& x, const std::vector<Vec3>& v, std::vector<Vec3> p) {
      std::vector<Vec3> r(p.size());
      for (std::size_t i = 0; i < p.size(); ++i)
        for (int k = 0; k < 3; ++k) r[i][k] = mass[i] * (p[i][k] - x[i][k] - dt * v[i][k] - dt * dt * kEarth[k]);
      for (const Quad& t : mesh.faces)
        for (int j = 0; j < 3; ++j)
          for (int k = 0; k < 3; ++k) {
            constexpr double by = 1e-6;
            double& at = p[t[j]][k];
            const double before = at;
            at = before + by;
            const double above = energy(p, t);
            at = before - by;
            const double below = energy(p, t);
            at = before;
            r[t[j]][k] += dt * dt * (above - below) / (2 * by);
          }
      double sum = 0;
      for (std::size_t i = 0; i < p.size(); ++i) sum += mass[i] > 0 ? std::pow(length(r[i]), 2) : 0;
      return std::sqrt(sum);
    };
    std::vector<double> left;
    for (const int refinements : {0, 10, 100, 1000}) {
      scene.solver.desbrun.refinement_iterations = refinements;
      Simulation refined(scene, {.threads = 1});
      const std::vector<Vec3> x = refined.positions(), v = refined.velocities();
      refined.step();
      left.push_back(residual(x, v, refined.positions()));
    }
    for (std::size_t k = 1; k < left.size(); ++k) EXPECT_LT(left[k], left[k - 1]) << pinned;
    EXPECT_LT(left.back(), 1e-6 * left.front()) << pinned;
  }
}

/// The largest relative change of the length of a side.
double largest_side_change(const Mesh& mesh, const std::vector<Vec3>& x) {
  double most = 0;
  for (const Edge& e : edges(mesh))
    most = std::max(most, std::abs(length(x[e[0]] - x[e[1]]) / length(mesh.points[e[0]] - mesh.points[e[1]]) - 1));
  return most;
}

TEST(Membrane, ComesBackFromATenthOfItsLength) {
  const TemporaryFolder folder;
  const Mesh mesh = uneven_sheet(0.3, 1, 4, 13, 7);
  for (const double nu : {0.0, 0.3, 0.9}) {
    BodySpec body;
    body.name = "sheet", body.mass = 1, body.damping = 0.1;
    body.shape = written(folder, mesh), body.constraints = {membrane(1e3, nu)};
    const Model model = build_model(scene_of({body}, {0, 0, 0}, 1.0 / 60, 10, Precision::Float));
    std::vector<Vec3> crushed = model.x;
    Random random(8);
    for (Vec3& at : crushed) at[1] *= 0.1, at[2] += random(-1e-3, 1e-3);
    const auto solver = make_solver(model, 1);
    solver->restore(save_state(state_at_rest<float>(crushed)));
    for (int step = 0; step < 300; ++step) solver->step();
    EXPECT_LT(largest_side_change(mesh, solver->positions()), 0.01) << nu;
  }
}

/// A ball of unequal triangles, some of them slivers of 1:50.
Mesh sliver_ball(unsigned seed) {
  Random random(seed);
  Mesh mesh = make_mesh(SphereShape{0.25, 2});
  const double cell = 0.07;
  for (Vec3& at : mesh.points)
    for (double& a : at) a += cell * random(-0.25, 0.25);
  const std::size_t faces = mesh.faces.size();
  for (std::size_t f = 0; f < faces; f += 7) {
    const auto [a, b, c, none] = mesh.faces[f];
    const Vec3 &A = mesh.points[a], &B = mesh.points[b], &C = mesh.points[c];
    Vec3 near;
    for (int k = 0; k < 3; ++k) near[k] = 0.49 * (A[k] + B[k]) + 0.02 * C[k];
    const int middle = static_cast<int>(mesh.points.size());
    mesh.points.push_back(near);
    mesh.faces[f] = {a, b, middle, -1};
    mesh.faces.push_back({b, c, middle, -1}), mesh.faces.push_back({c, a, middle, -1});
  }
  return mesh;
}

TEST(Membrane, OfAClosedShellOutlivesItsImpactHoweverSoftOrStiff) {
  const TemporaryFolder folder;
  const double high = 0.5, fastest = std::sqrt(2 * 9.81 * high);
  for (const std::string method : {"pbd", "desbrun"})
    for (const Precision precision : {Precision::Float, Precision::Double})
      for (double Y = 1; Y < 2e6; Y *= 100) {
        BodySpec shell;
        shell.name = "shell", shell.density = 0.3, shell.constraints = {membrane(Y, 0.3)};
        const Mesh mesh = sliver_ball(9);
        shell.shape = written(folder, mesh);
        shell.transform.translate = {0, high + 0.3, 0}, shell.spin = {3, -5, 2};
        Scene scene = scene_of({shell}, kEarth, 1.0 / 60, method == "pbd" ? 10 : 1, precision);
        scene.solver.type = method;
        EnvironmentSpec floor;
        floor.name = "ground", floor.shape = GridShape{{6, 6}, {1, 1}}, floor.transform.translate = {-3, 0, -3};
        floor.sides = Sides::OneSided;
        scene.environment = {floor};
        Simulation simulation(scene, {.threads = 1});
        double speed = 0;
        for (int step = 0; step < 60; ++step) {
          simulation.step();
          speed = std::max(speed, simulation.measure().speed_max);
        }
        EXPECT_LT(speed, 3 * fastest) << method << ", " << Y;
        if (Y >= 1e4) {
          EXPECT_LT(largest_side_change(mesh, simulation.positions()), 3) << method << ", " << Y;
        }
      }
}

}  // namespace
}  // namespace malha
