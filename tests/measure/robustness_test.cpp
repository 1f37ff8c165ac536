// SPDX-License-Identifier: Apache-2.0
// Difficult scenes: large ratios of masses, and scenes far from the origin. They stay finite, and their measures report
// the error.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/model/model.h"
#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// A chain of 20 links whose last particle weighs `ratio` times as much as each of the others.
struct Weighted {
  Model model;
  std::unique_ptr<Solver> solver;
  Weighted(double ratio, Precision precision, const std::string& type, int substeps, bool held, bool heavy_in_front) {
    BodySpec body = hung_chain({0, 0, 0}, {1, 0, 0}, 20, 0.01);
    body.constraints = {stiff("distance", {"edges"})};
    if (held) body.constraints.push_back(stiff("long_range", {}, 1, 0));
    Scene scene = scene_of({body}, kEarth, 1.0 / 60, substeps, precision);
    scene.solver.type = type;
    model = build_model(scene);
    for (int i = 0; i < model.count(); ++i)
      if (model.user_index[i] == (heavy_in_front ? 1 : 20)) model.w[i] /= ratio, model.mass[i] *= ratio;
    solver = make_solver(model, 1);
  }
  double strain_after(double seconds) {
    for (int step = 0; step < seconds * 60; ++step) solver->step();
    return solver->measure().strain_max;
  }
};

class MassRatio : public testing::TestWithParam<double> {};

/// PBD with a fixed number of projections stretches a chain that carries a heavy weight: 0.49 at 1:1000 with 10
/// substeps, and 35 at 1:100,000; springs of 10 kN/m stretch by m g / k, and by the swing. The measured strain shows
/// each.
TEST_P(MassRatio, StaysFiniteAndReportsItsStrain) {
  for (const char* type : {"pbd", "desbrun"})
    for (const Precision precision : {Precision::Float, Precision::Double})
      for (const bool heavy_in_front : {false, true}) {
        Weighted chain(GetParam(), precision, type, 10, false, heavy_in_front);
        const double strain = chain.strain_after(2);
        std::printf("a weight of %g at the %s of a chain, %s in %s: strain %.2f\n", GetParam(),
                    heavy_in_front ? "front" : "end", type, precision == Precision::Float ? "float" : "double", strain);
        EXPECT_TRUE(std::isfinite(strain)) << type;
        for (const Vec3& x : chain.solver->positions()) EXPECT_TRUE(std::isfinite(length(x))) << type;
        if (heavy_in_front)
          EXPECT_LT(strain, 0.25) << type << ": the light tail stretches little";
        else
          EXPECT_GT(strain, 1e-4 * GetParam()) << type << ": what hangs on a weight does, and it is said";
      }
}

TEST(MassRatioOfAThousand, MattersLessWithMoreSubsteps) {
  Weighted coarse(1e3, Precision::Double, "pbd", 10, false, false);
  Weighted fine(1e3, Precision::Double, "pbd", 40, false, false);
  const double few = coarse.strain_after(1), many = fine.strain_after(1);
  std::printf("10 substeps: strain %.3f, 40: %.3f\n", few, many);
  EXPECT_LT(many, few / 8) << "as h^2: 16 times less";
}

TEST_P(MassRatio, IsCuredByLongRangeAttachments) {
  for (const char* type : {"pbd", "desbrun"})
    for (const Precision precision : {Precision::Float, Precision::Double}) {
      Weighted chain(GetParam(), precision, type, 10, true, false);
      EXPECT_LT(chain.strain_after(2), 0.05) << type;
      for (const Vec3& x : chain.solver->positions()) EXPECT_LT(length(x), 1 + 1e-6) << type;
    }
}

INSTANTIATE_TEST_SUITE_P(Of, MassRatio, testing::Values(1e3, 1e5));

/// A cloth with edges of 25 mm hung by two corners, whose x, y and z are `far` from the origin.
Scene cloth(double far, Precision precision, const std::string& type) {
  BodySpec body;
  body.name = "cloth";
  body.shape = GridShape{{0.4, 0.4}, {16, 16}};
  body.transform.translate = {far, far, far};
  body.mass = 0.1;
  body.constraints = {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.1)};
  body.pins = {ListPin{{0, 16}}};
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10, precision);
  scene.solver.type = type;
  return scene;
}

TEST(NearTheOrigin, NoWarningIsGiven) {
  EXPECT_EQ(plan(Simulation(cloth(1, Precision::Float, "pbd"), {.threads = 1})).find("resolution"), std::string::npos);
}

class FarAway : public testing::TestWithParam<const char*> {};

TEST_P(FarAway, IsWrongByWhatThePrecisionResolvesUnderDesbrunsMethodAlone) {
  const double far = 10'000;
  const std::vector<Vec3> near = after(cloth(0, Precision::Double, GetParam()), 1).positions();
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const Simulation simulation = after(cloth(far, precision, GetParam()), 1);
    const std::vector<Vec3> x = simulation.positions();
    double error = 0;
    for (std::size_t i = 0; i < x.size(); ++i) error = std::max(error, length(x[i] - near[i] - Vec3{far, far, far}));
    std::printf("%s in %s at 10 km: off by %.1e m\n", GetParam(), precision == Precision::Float ? "float" : "double",
                error);
    const auto report = nlohmann::json::parse(simulation.report("finished"));
    if (precision == Precision::Double) {
      EXPECT_LT(error, 1e-7) << "double resolves 2e-12 m there";
      EXPECT_EQ(report["notes"].size(), 0u);
      continue;
    }
    if (GetParam() == std::string("pbd")) {
      EXPECT_LT(error, 1e-5) << "displacements of 4.5 cm a step, rounded and carried on";
      EXPECT_EQ(report["notes"].size(), 0u);
      continue;
    }
    EXPECT_LT(error, 0.05) << "the filter's forces are those of rounded places: 20 mm when measured";
    ASSERT_EQ(report["notes"].size(), 1u);
    const std::string note =
        "float resolves 0.98 mm at 10 km from the origin, where the shortest edge is 25 mm long: every rounding may "
        "strain it by 0.039; take \"precision\": \"double\" or move the scene to the origin";
    EXPECT_EQ(report["notes"][0], note);
    EXPECT_NEAR(report["resolution"]["spacing_m"], std::pow(2, -10), 1e-12);
    EXPECT_NE(plan(Simulation(cloth(far, precision, GetParam()), {.threads = 1})).find("\nresolution: " + note),
              std::string::npos);
  }
}
INSTANTIATE_TEST_SUITE_P(Under, FarAway, testing::Values("pbd", "desbrun"));

// The displacement of a substep is far less than the spacing of floats at that position, but is not rounded away:
// displacements are stored by themselves, and the rounding error of a position is carried on.
TEST(FloatInAThousandSubsteps, HangsAChainWhereDoubleDoesFarFromTheOriginToo) {
  for (const double far : {0.0, 1000.0}) {
    BodySpec chain = hung_chain({far, far, far}, {far + 1, far, far}, 20, 0.01);
    chain.constraints = {stiff("distance", {"edges"})};
    const Simulation once = after(scene_of({chain}, kEarth, 1.0 / 60, 1024, Precision::Float), 0.5);
    const Simulation twice = after(scene_of({chain}, kEarth, 1.0 / 60, 1024), 0.5);
    const std::vector<Vec3> x = once.positions(), right = twice.positions();
    for (std::size_t i = 0; i < x.size(); ++i)
      // Velocities of 4 m/s are rounded by 1.2e-7 of 2 at most, in the same direction for a while: g h is 1.6e-4 m/s,
      // 1e-3 of it, of 1.2 m.
      EXPECT_LT(length(x[i] - right[i]), 3e-4) << i << " at " << far;
  }
}

TEST(FloatInAThousandSubsteps, GivesATurningShellNoEnergy) {
  BodySpec shell;
  shell.name = "shell", shell.shape = SphereShape{0.5, 2}, shell.mass = 1, shell.spin = {2, 3, -1};
  shell.constraints = {compliant("distance", 0.01, {"edges"})};
  Simulation simulation(scene_of({shell}, {}, 1.0 / 60, 1024, Precision::Float), {.threads = 1});
  const Measures start = simulation.measure();
  for (int step = 0; step < 60; ++step) simulation.step();
  const Measures end = simulation.measure();
  EXPECT_NEAR(end.energy(), start.energy(), 1e-3 * start.energy());
  EXPECT_LT(length(end.angular_momentum - start.angular_momentum), 1e-4 * length(start.angular_momentum));
}

}  // namespace
}  // namespace malha
