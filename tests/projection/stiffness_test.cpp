// SPDX-License-Identifier: Apache-2.0
// PBD's stiffness k: the error that iterations and substeps leave, and the stiffness of a step, which is that of a
// spring.
#include "host/projection/stiffness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/refusal.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kFrameTime = 1.0 / 60;

/// A mass below a pin, 1 m away, on a constraint whose rest length is shorter by `too_long`.
Scene on_a_constraint(double k, double too_long, int substeps, int iterations, bool of_step, const Vec3& gravity = {}) {
  BodySpec body = hung_chain({0, 0, 0}, {0, -1, 0}, 1, 0.7);
  body.constraints = {stiff("distance", {"edges"}, k, 1 - too_long)};
  Scene scene = scene_of({body}, gravity, kFrameTime, substeps);
  scene.solver.iterations = iterations, scene.solver.stiffness_of_step = of_step;
  return scene;
}

double height_after(const Scene& scene, int steps) { return after(scene, steps * scene.solver.dt).positions()[1][1]; }

TEST(PbdStiffness, LeavesOneMinusKAfterTheIterationsOfAStep) {
  for (const bool of_step : {false, true})
    for (const double k : {0.0, 0.3, 0.5, 0.9, 1.0})
      for (const int iterations : {1, 3, 10})
        EXPECT_NEAR(-height_after(on_a_constraint(k, 0.1, 1, iterations, of_step), 1) - 0.9, 0.1 * (1 - k), 1e-14)
            << "k = " << k << ", " << iterations << " iterations";
}

/// Each substep removes its share of an error that inertia continues: C' = r (2 C - C before).
TEST(PbdStiffness, LeavesSomethingElseAfterSubsteps) {
  for (const double k : {0.1, 0.5, 0.9})
    for (const int n : {1, 2, 10, 40}) {
      const double r = std::pow(1 - k, 1.0 / n), left = std::pow(r, n / 2.0) * std::cos(n * std::acos(std::sqrt(r)));
      EXPECT_NEAR(-height_after(on_a_constraint(k, 0.1, n, 1, false), 1) - 0.9, 0.1 * left, 1e-13) << k << " " << n;
    }
  EXPECT_NEAR(-height_after(on_a_constraint(0.5, 0.1, 10, 1, false), 1) - 0.9, -0.061, 0.001) << "the default";
}

/// k makes a spring of m k / ((1 - k) dt^2) N/m: a weight that starts at its equilibrium stays there, to rounding.
TEST(StiffnessOfAStep, CarriesAWeightAtTheSameSagWithAnySubsteps) {
  for (const double k : {0.05, 0.5, 0.9})
    for (const int substeps : {1, 2, 10, 40})
      for (const int iterations : {1, 3}) {
        const double sag = 9.81 * kFrameTime * kFrameTime * (1 - k) / k;
        EXPECT_NEAR(height_after(on_a_constraint(k, sag, substeps, iterations, true, kEarth), 60), -1, 1e-12)
            << "k = " << k << ", " << substeps << " substeps of " << iterations;
      }
}

TEST(StiffnessOfAStep, SwingsAsItsSpring) {
  const double k = 0.02, omega = std::sqrt(k / (1 - k)) / kFrameTime;
  for (const int steps : {10, 25, 44}) {  // of 44 that a period takes
    const double exact = -1 + 0.1 * (1 - std::cos(omega * steps * kFrameTime));
    // Backward Euler's damping: amplitudes fall as exp(-omega^2 h t / 2), by 1 % in a period.
    EXPECT_NEAR(height_after(on_a_constraint(k, 0.1, 50, 1, true), steps), exact, 0.002) << steps;
  }
}

/// Each link of a chain is the spring of its own two masses, and carries the weight below it.
TEST(StiffnessOfAStep, StretchesAChainAsItsSprings) {
  constexpr int links = 4;
  constexpr double k = 0.5;
  for (const int substeps : {20, 60}) {
    BodySpec body = hung_chain({0, 0, 0}, {0, -2, 0}, links);
    body.constraints = {stiff("distance", {"edges"}, k)};
    Scene scene = scene_of({body}, kEarth, kFrameTime, substeps);
    scene.solver.stiffness_of_step = true;
    scene.wind = Wind{{0, 0, 0}, 20};
    const std::vector<Vec3> x = after(scene, 3).positions();
    const double mass = *body.mass / links;  // of inner ones; half at the ends
    for (int i = 0; i < links; ++i) {
      const double below = mass * (links - i - 0.5), w = (i > 0) / mass + (i + 1 == links ? 2 : 1) / mass;
      const double stretched = kFrameTime * kFrameTime * (1 - k) / k * w * below * 9.81;
      // One sweep a substep resolves the coupling of neighbouring links to some (omega h)^2: 7 % and 0.7 %.
      EXPECT_NEAR(length(x[i + 1] - x[i]) - 0.5, stretched, 30.0 / (substeps * substeps) * stretched) << i;
    }
  }
}

TEST(StiffnessOfAStep, IsReadAndWrittenAndForPbdAlone) {
  const auto text = [](const std::string& solver) {
    return R"({"name": "s", "solver": )" + solver +
           R"(, "bodies": [{"name": "b", "mass": 1, "shape": {"lattice": {"min": [0, 0, 0], "max": [0, 0, 0],
               "count": [1, 1, 1]}}}], "duration": 1})";
  };
  const auto read = [&](const std::string& solver) { return parse_scene(text(solver), "s.json", "."); };
  EXPECT_FALSE(read(R"({"type": "pbd"})").solver.stiffness_of_step);
  const Scene scene = read(R"({"type": "pbd", "stiffness_basis": "step"})");
  EXPECT_TRUE(scene.solver.stiffness_of_step);
  EXPECT_TRUE(parse_scene(to_json(scene), "s.json", ".").solver.stiffness_of_step);
  EXPECT_EQ(
      refusal([&] { read(R"({"type": "pbd", "stiffness_basis": "steps"})"); }),
      "s.json: /solver/stiffness_basis: found unknown choice \"steps\" (did you mean 'step'?); allowed: projections, "
      "step");
  EXPECT_EQ(refusal([&] {
              read(R"({"type": "desbrun", "stiffness_basis": "step"})");
            }).find("s.json: /solver/stiffness_basis: found unknown key 'stiffness_basis'"),
            0u);
}

}  // namespace
}  // namespace malha
