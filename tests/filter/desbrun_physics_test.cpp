// SPDX-License-Identifier: Apache-2.0
// Desbrun's method on bodies whose motion or rest state is known: oscillators, hanging chains and sheets, stiff cloth,
// with and without distance limits, contact and pressure.
#include <gtest/gtest.h>

#include <complex>

#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

/// A mass of 1 kg on a spring of 1 m and 1000 N/m, stretched by 0.5 m. Along the spring the method is implicit Euler.
Scene oscillator(double h, bool free = false) {
  Scene scene = desbrun_scene({hung_chain({0, 0, 0}, {1.5, 0, 0}, 1)}, 1000);
  scene.solver.dt = h;
  scene.gravity = {0, 0, 0};
  scene.bodies[0].constraints = {stiff("distance", {"edges"}, 1, 1 / 1.5)};
  if (free) scene.bodies[0].pins.clear();
  return scene;
}

TEST(FilteredOscillator, IsImplicitEulerToTheLastDigits) {
  const std::complex<double> i(0, 1);
  const double omega = std::sqrt(1000.0);
  for (const double h : {1e-4, 1e-3, 1e-2, 0.1}) {
    Simulation simulation(oscillator(h), {.threads = 1});
    std::complex<double> state = 0.5;  // u + i v / omega turns by -omega h and shrinks
    for (int step = 0; step < 200; ++step) {
      simulation.step();
      state /= 1.0 + i * omega * h;
      ASSERT_NEAR(simulation.positions()[1][0] - 1, state.real(), 1e-11) << h << ", step " << step;
      ASSERT_NEAR(simulation.velocities()[1][0] / omega, state.imag(), 1e-11) << h << ", step " << step;
    }
  }
}

TEST(FilteredOscillator, SwingsAsTheSpringDoesInTheLimitOfSmallSteps) {
  const double exact = 2 * kPi / std::sqrt(1000.0);
  const auto error = [&](double h) {
    Simulation simulation(oscillator(h), {.threads = 1});
    std::vector<double> passages;  // times at which it passes the rest length, interpolated
    for (double before = 0.5; passages.size() < 5;) {
      simulation.step();
      const double u = simulation.positions()[1][0] - 1;
      if ((u < 0) != (before < 0)) passages.push_back(simulation.time() - h * u / (u - before));
      before = u;
    }
    return (passages[4] - passages[0]) / 2 / exact - 1;
  };
  const double coarse = error(1e-3), fine = error(2.5e-4);
  EXPECT_NEAR(fine, 1000 * 6.25e-8 / 3, 1e-5);  // atan(s) = s - s^3 / 3, s = omega h
  EXPECT_NEAR(coarse / fine, 16, 2) << "as the square of the step";
}

TEST(FilteredOscillator, OfTwoFreeMassesSwingsWithTheReducedMass) {
  const Simulation simulation = after(oscillator(1e-3, true), 0.2);
  const std::complex<double> state = 0.5 * std::pow(1.0 + std::complex<double>(0, std::sqrt(2000.0) * 1e-3), -200);
  const std::vector<Vec3> x = simulation.positions();
  EXPECT_NEAR(length(x[1] - x[0]) - 1, state.real(), 1e-11);
  EXPECT_NEAR(x[0][0] + x[1][0], 1.5, 1e-12);  // the centre of mass stays
}

TEST(FilteredOscillator, SubstepsAreShorterSteps) {
  Scene substeps = oscillator(0.01);
  substeps.solver.substeps = 10;
  EXPECT_NEAR(after(oscillator(1e-3), 0.5).positions()[1][0], after(substeps, 0.5).positions()[1][0], 1e-12);
}

/// A chain of 5 springs of 300 N/m, 20 cm and 0.24 kg each, at rest after 20 s; its end has half of that mass.
std::vector<double> settled_lengths(bool internal_only, int refinements) {
  BodySpec chain = hung_chain({0, 0, 0}, {0, -1, 0}, 5, 0.2);
  chain.constraints = {stiff("distance", {"edges"})};
  Scene scene = desbrun_scene({chain}, 300);
  scene.solver.desbrun.filter_external_forces = !internal_only,
  scene.solver.desbrun.refinement_iterations = refinements;
  const std::vector<Vec3> x = after(scene, 20).positions();
  std::vector<double> lengths;
  for (int i = 1; i <= 5; ++i) lengths.push_back(length(x[i] - x[i - 1]));
  return lengths;
}

TEST(HangingChain, SettlesWhereEverySpringCarriesWhatHangsOnIt) {
  for (const int refinements : {0, 3}) {
    const std::vector<double> lengths = settled_lengths(false, refinements);
    for (int i = 1; i <= 5; ++i) EXPECT_NEAR(lengths[i - 1], 0.2 + (0.12 + 0.24 * (5 - i)) * 9.81 / 300, 1e-9) << i;
  }
}

// The chain rests where S F + g = 0, F = -A g 1: besides the weight -m g there is -dt^2 L 1 g, which pulls at the
// particles next to a pin, as if that spring were longer by g dt^2 at the pin. Backward Euler has no such force, and
// refinement removes it.
TEST(HangingChain, WhoseWeightGoesRoundTheFilterHangsLowerByOneFreeFallOfAStep) {
  for (const int refinements : {0, 3}) {
    const std::vector<double> lengths = settled_lengths(true, refinements);
    for (int i = 1; i <= 5; ++i)
      EXPECT_NEAR(lengths[i - 1],
                  0.2 + (0.12 + 0.24 * (5 - i)) * 9.81 / 300 + (i == 1 && refinements == 0 ? 9.81 / 3600 : 0), 1e-9)
          << i << ", refined " << refinements;
  }
}

/// The pin of a chain moves up and the chain follows, with the same filter.
TEST(HangingChain, FollowsAPinThatIsMoved) {
  for (const char* method : {"desbrun", "pbd"}) {
    Scene scene = desbrun_scene({hung_chain({0, 0, 0}, {0, -1, 0}, 8)}, 1e4);
    scene.solver.type = method, scene.solver.substeps = 4;
    scene.bodies[0].constraints = {compliant("distance", 1e-4, {"edges"})};
    scene.bodies[0].damping = 0.2;
    Simulation simulation(scene, {.threads = 1});
    run_for(simulation, scene, 3);
    const std::vector<Vec3> before = simulation.positions();
    simulation.move_pin(0, {0, 0.05, 0});
    EXPECT_EQ(simulation.positions()[0], (Vec3{0, 0.05, 0}));
    run_for(simulation, scene, 20);
    const std::vector<Vec3> x = simulation.positions();
    for (std::size_t i = 0; i < x.size(); ++i)
      EXPECT_LT(length(x[i] - before[i] - Vec3{0, 0.05, 0}), 1e-3) << method << ", particle " << i;
    EXPECT_THROW(simulation.move_pin(1, {0, 0, 0}), InputError) << "not pinned";
    EXPECT_THROW(simulation.move_pin(9, {0, 0, 0}), InputError) << "no such particle";
  }
}

/// Wind is an external force, as gravity is: filtered, it hardly moves the particle next to a pin, unfiltered it does.
TEST(HangingChain, FeelsTheWindAsItFeelsItsWeight) {
  Scene scene = desbrun_scene({hung_chain({0, 0, 0}, {0, -1, 0}, 2)}, 1e6);
  scene.gravity = {0, 0, 0};
  scene.wind = Wind{{0, 0, 1}, 0.6};
  scene.bodies[0].constraints = {stiff("distance", {"edges"})};
  const auto path = [&](bool internal_only) {
    scene.solver.desbrun.filter_external_forces = !internal_only;
    return after(scene, scene.solver.dt).positions()[1][2];
  };
  const double dt = scene.solver.dt, h = dt * 0.6 / 1.5;  // drag over mass, times dt
  EXPECT_NEAR(path(true), dt * h / (1 + h), 1e-12) << "as if there were no spring";
  EXPECT_LT(path(false), 0.05 * path(true));
}

TEST(HangingSheet, PullsAtItsPinsWithItsWeight) {
  Scene scene = desbrun_scene({sprung_sheet(8, {ListPin{{0, 8}}})}, 200);
  scene.bodies[0].transform.degrees = 90, scene.bodies[0].transform.axis = {1, 0, 0};
  scene.wind = Wind{{0, 0, 0}, 0.002};  // still air, which damps it until it rests
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 2400; ++step) simulation.step();
  const Model model = build_model(scene);
  const std::vector<Vec3> x = simulation.positions();
  EXPECT_LT(simulation.measure().speed_max, 1e-6) << "it hangs still";
  Vec3 pull{0, 0, 0};
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s)
      for (const int e : {0, 1}) {
        if (model.w[set.ends[s][e]] > 0) continue;
        const Vec3 d = x[model.user_index[set.ends[s][1 - e]]] - x[model.user_index[set.ends[s][e]]];
        for (int k = 0; k < 3; ++k) pull[k] += set.stiffness[s] * (1 - set.rest[s] / length(d)) * d[k];
      }
  for (const FoldReference& fold : folds_of(model)) {
    Vec3 f{0, 0, 0};
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k) f[k] += fold.weight[j] * x[model.user_index[fold.of[j]]][k];
    ASSERT_EQ(fold.rest, 0) << "a flat sheet";
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3 && model.w[fold.of[j]] == 0; ++k) pull[k] -= fold.stiffness * fold.weight[j] * f[k];
  }
  double mass = 0;
  for (const double w : model.w) mass += w > 0 ? 1 / w : 0;
  EXPECT_NEAR(pull[0], 0, 1e-4 * mass * 9.81);
  EXPECT_NEAR(pull[1], -mass * 9.81, 1e-4 * mass * 9.81);
  EXPECT_NEAR(pull[2], 0, 1e-4 * mass * 9.81);
}

TEST(Pins, OfAFilteredBodyDoNotMoveByABit) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const bool internal_only : {false, true}) {
      BodySpec sheet = sprung_sheet(6, {ListPin{{0, 6, 20}}});
      sheet.velocity = {1, 2, 3}, sheet.damping = 0.1;
      Scene scene = desbrun_scene({sheet}, 1e4, precision);
      scene.wind = Wind{{3, 0, 1}, 0.01};
      scene.solver.desbrun.filter_external_forces = !internal_only;
      Simulation simulation(scene, {.threads = 1});
      const std::vector<Vec3> start = simulation.positions();
      for (int step = 0; step < 50; ++step) simulation.step();
      for (const int pin : {0, 6, 20}) {
        EXPECT_EQ(simulation.positions()[pin], start[pin]);
        EXPECT_EQ(simulation.velocities()[pin], (Vec3{0, 0, 0}));
      }
      EXPECT_GT(length(simulation.positions()[40] - start[40]), 1e-5) << "others do";
    }
}

/// With steps of 1/30 s, k dt^2 / m is 1.5e7: explicit springs would need steps of some microseconds.
class StiffCloth : public testing::TestWithParam<std::tuple<Precision, FilterKind>> {
 protected:
  static Scene scene(std::vector<Pin> pins) {
    const auto [precision, kind] = GetParam();
    Scene scene = desbrun_scene({sprung_sheet(12, std::move(pins))}, 1e7, precision);
    scene.solver.dt = 1.0 / 30;
    scene.solver.desbrun.filter = kind;
    return scene;
  }
};

TEST_P(StiffCloth, HungNeverHasMoreEnergyThanItBeganWith) {
  const Scene hung = scene({ListPin{{0, 12}}});
  Simulation simulation(hung, {.threads = 1});
  const double start = simulation.measure().energy();
  for (int step = 0; step < 200; ++step) {
    simulation.step();
    // Rounding: 500 springs of 1e7 N/m, each to 3e-8 m of positions of 0.6 m in float.
    ASSERT_LT(simulation.measure().energy(), start + 500 * 1e7 * 1e-15 / 2) << step;
  }
}

// The sheet turns by 0.125 rad a step, along the tangent: it stretches by half the square of that, and its springs undo
// that while the body turns on.
TEST_P(StiffCloth, FreeTurnsOnWithItsAngularMomentumAndNoMoreEnergyOfMotion) {
  Scene turning = scene({});
  turning.gravity = {0, 0, 0};
  turning.bodies[0].spin = {2, 3, 1};
  Simulation simulation(turning, {.threads = 1});
  const Measures start = simulation.measure();
  const double stretch = 14.0 / 900 / 2;
  for (int step = 0; step < 200; ++step) {
    simulation.step();
    const Measures now = simulation.measure();
    ASSERT_LT(now.kinetic, start.kinetic * (1 + 1e-5)) << step;
    ASSERT_LT(now.strain_max, 1.5 * stretch) << step;  // the sheet turns faster about its own diagonals than on average
  }
  EXPECT_GT(simulation.measure().kinetic, 0.9 * start.kinetic) << "after 4 turns";
  EXPECT_LT(length(simulation.measure().angular_momentum - start.angular_momentum),
            1e-3 * length(start.angular_momentum));
}

TEST_P(StiffCloth, FreeStandsStillAfterAStepWithoutTheCorrector) {
  Scene turning = scene({});
  turning.gravity = {0, 0, 0};
  turning.bodies[0].spin = {2, 3, 1};
  turning.solver.desbrun.corrector = Corrector::Off;
  Simulation simulation(turning, {.threads = 1});
  const double start = simulation.measure().kinetic;
  simulation.step();
  EXPECT_LT(simulation.measure().kinetic, 1e-6 * start);
}

std::string cloth_name(const testing::TestParamInfo<std::tuple<Precision, FilterKind>>& tested) {
  return std::string(std::get<0>(tested.param) == Precision::Float ? "Float" : "Double") +
         (std::get<1>(tested.param) == FilterKind::Dense ? "Dense" : "Sparse");
}
INSTANTIATE_TEST_SUITE_P(, StiffCloth,
                         testing::Combine(testing::Values(Precision::Float, Precision::Double),
                                          testing::Values(FilterKind::Dense, FilterKind::Sparse)),
                         cloth_name);

}  // namespace
}  // namespace malha
