// SPDX-License-Identifier: Apache-2.0
// Desbrun's method solves one linear system towards backward Euler; with refinement iterations it converges to backward
// Euler.
#include <gtest/gtest.h>

#include "tests/filter/filter_reference.h"
#include "tests/filter/implicit_reference.h"

namespace malha {
namespace {

/// 6 x 6 particles of unequal masses in rotation, whose springs are stretched. (Where they are compressed a flat sheet
/// buckles: on the path from one shape to another the residual of an iteration grows before it falls.)
BodySpec strained_sheet(std::vector<Pin> pins) {
  BodySpec body;
  body.name = "sheet";
  body.shape = GridShape{{0.5, 0.5}, {5, 5}};
  body.mass = 0.5;
  body.spin = {3, -2, 4};
  body.velocity = {0.5, 1, 0};
  body.pins = std::move(pins);
  body.constraints = {stiff("distance", {"edges"}, 1, 0.6), stiff("distance", {"shear"}, 0.7, 0.8),
                      stiff("bending", {}, 0.3)};
  return body;
}

Scene strained(std::vector<Pin> pins, double stiffness = 500) {
  Scene scene = desbrun_scene({strained_sheet(std::move(pins))}, stiffness);
  scene.solver.desbrun.corrector = Corrector::Off;
  return scene;
}

Scene springs_alone(Scene scene) {
  scene.bodies[0].constraints.pop_back();
  return scene;
}

double largest(const Eigen::VectorXd& a) { return a.cwiseAbs().maxCoeff(); }

class OneSolve : public testing::TestWithParam<std::tuple<bool, FilterKind>> {
 protected:
  Scene scene(double stiffness) const {
    const auto [pinned, kind] = GetParam();
    Scene scene = strained(pinned ? std::vector<Pin>{ListPin{{0, 3}}} : std::vector<Pin>{}, stiffness);
    scene.solver.desbrun.filter = kind;
    return scene;
  }
};

// (M + dt^2 L) x' = M y + dt^2 J d(x), in the notation of Liu et al. 2013.
TEST_P(OneSolve, IsALocalGlobalIterationFromThePositions) {
  for (const double stiffness : {5.0, 500.0, 5e4}) {
    const Scene tested = scene(stiffness);
    const ImplicitReference reference(tested);
    Simulation simulation(tested, {.threads = 1});
    for (int step = 0; step < 20; ++step) {
      const Eigen::VectorXd x = study::flat(simulation.positions()), v = study::flat(simulation.velocities());
      simulation.step();
      const Eigen::VectorXd expected = reference.local_global(reference.inertial(x, v), x);
      const Eigen::VectorXd now = study::flat(simulation.positions());
      ASSERT_LT(largest(now - expected), 1e-12) << stiffness << ", step " << step;
      // v is the displacement over dt, and so is its rounding.
      ASSERT_LT(largest(study::flat(simulation.velocities()) - (now - x) * 60), 1e-11) << step;
    }
  }
}

TEST_P(OneSolve, IsTheFirstOfManyThatLeadToBackwardEuler) {
  Scene tested = scene(500);
  const ImplicitReference reference(tested);
  const Simulation start(tested, {.threads = 1});
  const Eigen::VectorXd x = study::flat(start.positions());
  const Eigen::VectorXd y = reference.inertial(x, study::flat(start.velocities()));
  Eigen::VectorXd p = x;
  for (int r = 0; r <= 5; ++r) {
    p = reference.local_global(y, p);
    tested.solver.desbrun.refinement_iterations = r;
    Simulation simulation(tested, {.threads = 1});
    simulation.step();
    EXPECT_LT(largest(study::flat(simulation.positions()) - p), 1e-12) << r;
  }
}

std::string solve_name(const testing::TestParamInfo<std::tuple<bool, FilterKind>>& tested) {
  return std::string(std::get<0>(tested.param) ? "Pinned" : "Free") +
         (std::get<1>(tested.param) == FilterKind::Dense ? "Dense" : "Sparse");
}
INSTANTIATE_TEST_SUITE_P(, OneSolve,
                         testing::Combine(testing::Bool(), testing::Values(FilterKind::Dense, FilterKind::Sparse)),
                         solve_name);

class Refined : public testing::TestWithParam<bool> {
 protected:
  Refined()
      : scene_(springs_alone(strained(GetParam() ? std::vector<Pin>{ListPin{{0, 3}}} : std::vector<Pin>{}))),
        reference_(scene_) {
    const Simulation start(scene_, {.threads = 1});
    x_ = study::flat(start.positions()), v_ = study::flat(start.velocities());
    y_ = reference_.inertial(x_, v_);
  }
  Eigen::VectorXd after_one_step(int refinements, Precision precision = Precision::Double) const {
    Scene scene = scene_;
    scene.solver.desbrun.refinement_iterations = refinements;
    scene.solver.precision = precision;
    Simulation simulation(scene, {.threads = 1});
    simulation.step();
    return study::flat(simulation.positions());
  }

  Scene scene_;
  ImplicitReference reference_;
  Eigen::VectorXd x_, v_, y_;
};

TEST_P(Refined, LeavesLessAndLessOfBackwardEulersResidual) {
  const double start = reference_.residual(y_, y_).norm();
  std::vector<double> left;
  for (const int r : {0, 1, 2, 4, 8, 16, 32}) left.push_back(reference_.residual(y_, after_one_step(r)).norm() / start);
  EXPECT_LT(left[0], 0.5);
  for (std::size_t k = 1; k < left.size(); ++k) EXPECT_LT(left[k], left[k - 1]) << k;

  // Linear, at last as the sheet's slowest mode: 0.97 a refinement here.
  EXPECT_LT(left[5], left[0] / 10);
  EXPECT_LT(left[6], 0.6 * left[5]);
}

TEST_P(Refined, BecomesBackwardEulerOfTheSprings) {
  const Eigen::VectorXd found = after_one_step(1000), expected = reference_.backward_euler(x_, v_);
  EXPECT_LT(reference_.residual(y_, expected).norm(), 1e-12) << "Newton's own";
  EXPECT_LT(largest(found - expected), 1e-10);
  EXPECT_GT(largest(after_one_step(0) - expected), 1e-4) << "which the paper's method is not";
  // In float: positions of 0.5 m to 3e-8 m, through a filter that is exact to 1e-6 of a displacement of some cm.
  EXPECT_LT(largest(after_one_step(1000, Precision::Float) - expected), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(, Refined, testing::Bool(),
                         [](const auto& tested) { return std::string(tested.param ? "Pinned" : "Free"); });

/// The torque that the filter leaves is an error like the residual, and decreases with it.
TEST(RefinedFreeBody, LosesTheTorqueOfTheFilteredForces) {
  Scene scene = strained({});
  const ImplicitReference reference(scene);
  const auto torque = [&](int refinements) {
    scene.solver.desbrun.refinement_iterations = refinements;
    Simulation simulation(scene, {.threads = 1});
    const std::vector<Vec3> before = simulation.velocities();
    simulation.step();
    const std::vector<Vec3> p = simulation.positions(), v = simulation.velocities();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < p.size(); ++i)
      sum += Eigen::Vector3d(p[i][0], p[i][1], p[i][2])
                 .cross(reference.mass(static_cast<int>(i)) * 60 *
                        Eigen::Vector3d(v[i][0] - before[i][0], v[i][1] - before[i][1] + 9.81 / 60,
                                        v[i][2] - before[i][2]));
    return sum.norm();
  };
  const double once = torque(0);
  EXPECT_GT(once, 1e-3);
  EXPECT_LT(torque(8), once / 2);
  EXPECT_LT(torque(1000), 1e-9 * once);
}

/// In the paper gravity is not filtered: x' = y + dt^2 S F, with F without the weight.
TEST(InternalOnly, FiltersTheSpringsAlone) {
  Scene scene = strained({ListPin{{0, 3}}});
  scene.solver.desbrun.filter_external_forces = false;
  const Simulation start(scene, {.threads = 1});
  Scene floating = scene;
  floating.gravity = {0, 0, 0};
  const ImplicitReference reference(floating), weighed(scene);
  const Eigen::VectorXd x = study::flat(start.positions()), v = study::flat(start.velocities());
  const Eigen::VectorXd fall = weighed.inertial(x, v) - reference.inertial(x, v);
  const Eigen::VectorXd expected = reference.local_global(reference.inertial(x, v), x) + fall;
  Simulation simulation(scene, {.threads = 1});
  simulation.step();
  EXPECT_LT(largest(study::flat(simulation.positions()) - expected), 1e-12);
  // Backward Euler filters all forces, so that the weight is in the residual from the first refinement on.
  scene.solver.desbrun.refinement_iterations = 1000;
  Simulation refined(scene, {.threads = 1});
  refined.step();
  EXPECT_GT(largest(study::flat(refined.positions()) - expected), 1e-4);
}

}  // namespace
}  // namespace malha
