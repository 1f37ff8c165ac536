// SPDX-License-Identifier: Apache-2.0
// The amplification of small motions about rest by a substep: against eigenvalues of the same step's Jacobian, and for
// sweeps in one direction.
#include "host/report/amplification.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>

#include "host/report/plan.h"
#include "malha/simulation.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// An irregular sheet of few triangles.
Shape amplified_sheet(const TemporaryFolder& folder) {
  Random random(5);
  return MeshFile{folder.write("sheet.obj", irregular_sheet(0.5, 0.4, 4, 3, random))};
}

/// The spectral radius of a step's Jacobian about the start: by central differences over positions and velocities of
/// all movable particles.
double jacobian_spectral_radius(Scene scene) {
  scene.solver.precision = Precision::Double;
  Simulation simulation(scene, {.threads = 1});
  const std::vector<Vec3> x = simulation.positions(), still(x.size(), {0, 0, 0});
  const std::vector<double> w = simulation.inverse_masses();
  std::vector<int> of;  // coordinates
  for (std::size_t i = 0; i < 3 * x.size(); ++i)
    if (w[i / 3] > 0) of.push_back(static_cast<int>(i));
  const int n = static_cast<int>(of.size());
  Eigen::MatrixXd J(2 * n, 2 * n);
  const double small = 1e-6;  // of 0.1 m edges: squares are 1e-5 of it, rounding 1e-9
  for (int column = 0; column < 2 * n; ++column)
    for (const double sign : {1.0, -1.0}) {
      std::vector<Vec3> p = x, v = still;
      const int k = of[column % n];
      (column < n ? p : v)[k / 3][k % 3] += sign * small;
      simulation.set_positions(p), simulation.set_velocities(v);
      simulation.step();
      p = simulation.positions(), v = simulation.velocities();
      for (int row = 0; row < 2 * n; ++row) {
        const int r = of[row % n];
        const double value = (row < n ? p : v)[r / 3][r % 3] / (2 * small);
        J(row, column) = sign > 0 ? value : J(row, column) - value;
      }
    }
  return J.eigenvalues().cwiseAbs().maxCoeff();
}

TEST(Amplification, IsTheSpectralRadiusOfTheStepsJacobian) {
  const TemporaryFolder folder;
  // Springs and hinges all have an effect, so that no zero modes, whose eigenvalues are 1, hide the others.
  BodySpec sheet =
      body("sheet", amplified_sheet(folder), {compliant("distance", 2e-3, {"edges"}), compliant("bending", 0.5)});
  sheet.pins = {BoxPin{{-1, -1, -1}, {1, 1, 0.18}}};  // two rows, so that the others cannot rotate about one
  Scene pbd = scene_of({sheet});
  pbd.solver.substeps = 3;
  Scene desbrun = pbd;
  desbrun.solver.type = "desbrun", desbrun.solver.substeps = 1;
  // The paper's corrector on a free body adds rotation at every step: that is known to grow.
  Scene grows = scene_of({body("sheet", amplified_sheet(folder), {constraint("distance")})});
  grows.bodies[0].mass = 0.01;
  grows.solver.type = "desbrun", grows.solver.desbrun.corrector = Corrector::Paper;
  for (const Scene* scene : {&pbd, &desbrun, &grows}) {
    const std::optional<Amplification> found = measure_amplification(*scene, 0, 2400);
    ASSERT_TRUE(found);
    const double growth = std::log(jacobian_spectral_radius(*scene)) / scene->solver.dt;
    // Peaks of an oscillation are sampled once a step, and modes near the largest decay slowly beside it.
    EXPECT_NEAR(found->growth, growth, 0.05 * std::abs(growth) + 0.02);
    EXPECT_NEAR(found->of_a_substep(scene->solver), std::exp(growth * scene->solver.dt / scene->solver.substeps), 1e-2);
    EXPECT_EQ(growth > 1, scene == &grows);
    EXPECT_EQ(found->grows(), scene == &grows);
  }
}

/// The product of the linearised projections on the constraints "edge k keeps its length", in this order: each moves
/// its ends by their inverse masses along the edge, so that the linearised length is met.
Eigen::MatrixXd sweep_over(const std::vector<Edge>& edges, const std::vector<Vec3>& x, const std::vector<double>& w) {
  const int n = 3 * static_cast<int>(x.size());
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n, n);
  for (const Edge& edge : edges) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n), step = gradient;
    const Vec3 along = x[edge[0]] - x[edge[1]];
    double sum = 0;
    for (int a = 0; a < 3; ++a)
      for (int end = 0; end < 2; ++end) {
        const double g = (end == 0 ? 1 : -1) * along[a] / length(along);
        gradient[3 * edge[end] + a] = g, step[3 * edge[end] + a] = w[edge[end]] * g;
        sum += w[edge[end]] * g * g;
      }
    T -= step * (gradient.transpose() * T) / sum;
  }
  return T;
}

/// The spectral radius of a substep y' = T (2 y - y before).
double amplification_by(const Eigen::MatrixXd& T) {
  double most = 0;
  for (const std::complex<double> mu : Eigen::VectorXcd(T.eigenvalues())) {
    const std::complex<double> root = std::sqrt(mu * mu - mu);
    most = std::max({most, std::abs(mu + root), std::abs(mu - root)});
  }
  return most;
}

TEST(Amplification, IsAboveOneOfSweepsInOneDirectionAndNotOfSweepsThereAndBack) {
  const Scene scene = scene_of({body("shell", SphereShape{0.5, 2}, {constraint("distance")})});
  const Model model = build_model(scene);
  const Simulation simulation(scene, {.threads = 1});
  const std::vector<Vec3> x = simulation.positions();
  const std::vector<double> w = simulation.inverse_masses();
  std::vector<Edge> edges;
  const ConstraintSet& set = model.sets[0];
  for (int c = 0; c < set.count(); ++c) {
    const int i = model.user_index[set.particles[2 * c]], j = model.user_index[set.particles[2 * c + 1]];
    edges.push_back({std::min(i, j), std::max(i, j)});
  }
  std::sort(edges.begin(), edges.end());
  const Eigen::MatrixXd there = sweep_over(edges, x, w);
  std::reverse(edges.begin(), edges.end());
  const Eigen::MatrixXd back = sweep_over(edges, x, w);
  EXPECT_GT(amplification_by(there), 1.01);  // 400 times as fast after a second of 10 substeps a step
  // Zero modes have the double eigenvalue 1, whose root the rounding of a matrix shows.
  EXPECT_LT(amplification_by(back * there), 1 + 1e-6);
  const std::optional<Amplification> ours = measure_amplification(scene, 0, 600);
  ASSERT_TRUE(ours);
  EXPECT_LT(ours->of_a_substep(scene.solver), 1 + 1e-6);
  EXPECT_FALSE(ours->grows());
}

TEST(Amplification, IsOfTheConstraintsAlone) {
  BodySpec sheet = body("sheet", GridShape{{0.5, 0.5}, {6, 6}}, {constraint("distance"), stiff("bending", {}, 0.1)});
  Scene scene = scene_of({sheet});
  const std::optional<Amplification> plain = measure_amplification(scene, 0, 60);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->damping, 0);
  scene.gravity = kEarth, scene.wind = Wind{{3, 0, 0}, 0.1}, scene.self_collision.emplace().thickness = 0.01;
  scene.environment = {obstacle("ball", SphereShape{0.1, 1})};
  scene.bodies[0].velocity = {1, 2, 3}, scene.bodies[0].damping = 0.1;
  const std::optional<Amplification> all = measure_amplification(scene, 0, 60);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->growth, plain->growth);
  const double heaviest = 1.0 / 36;  // kg: of 1 kg over 36 cells
  EXPECT_NEAR(all->damping, -std::log(0.9) * 60 + 0.1 / heaviest, 1e-9);
}

TEST(Amplification, IsMeasuredWhereABodyComesToRest) {
  // A sheet that is too large for its pinned boundary buckles: no small motion about the flat state is one about rest.
  BodySpec pressed = body("sheet", GridShape{{0.5, 0.5}, {6, 6}}, {compliant("distance", 1e-3, {"edges"}, 1.1)});
  pressed.pins = {RowPin{}, RowPin{true}};
  EXPECT_FALSE(measure_amplification(scene_of({pressed}), 0, 60));
  const BodySpec blown = body("ball", SphereShape{0.3, 2}, {constraint("distance"), constraint("pressure", 1.2)});
  const std::optional<Amplification> ball = measure_amplification(scene_of({blown}), 0, 60);
  ASSERT_TRUE(ball);
  EXPECT_FALSE(ball->grows());
}

TEST(Amplification, IsReportedOfRunsThatPayAHundredthForIt) {
  BodySpec sheet = body("sheet", GridShape{{0.5, 0.5}, {6, 6}}, {constraint("distance")});
  sheet.mass = 0.01;
  Scene scene = scene_of({sheet, sheet});
  scene.bodies[1].name = "second";
  scene.solver.type = "desbrun", scene.solver.desbrun.corrector = Corrector::Paper;
  const Model model = build_model(scene);
  const auto of_run = [&](std::int64_t steps) {
    return growth_warnings(model, measure_amplifications(model, amplification_steps_of_run(steps)));
  };
  EXPECT_EQ(of_run(600).size(), 0u) << "too short";
  ASSERT_EQ(of_run(20'000).size(), 2u);
  EXPECT_TRUE(has(of_run(20'000)[1], "'second'"));
  const std::vector<std::optional<Amplification>> planned =
      measure_amplifications(model, amplification_steps_of_plan(model));
  EXPECT_EQ(growth_warnings(model, planned).size(), 2u);
  EXPECT_TRUE(has(plan(Simulation(scene), nullptr, &planned), "\namplification:\n  sheet: of_a_substep "));
  scene.solver.desbrun.corrector.reset();
  const Model corrected = build_model(scene);
  EXPECT_TRUE(growth_warnings(corrected, measure_amplifications(corrected, 1e9)).empty());
}

}  // namespace
}  // namespace malha
