// SPDX-License-Identifier: Apache-2.0
// Cloths, chains and balloons: residuals of their constraints, and their rest states.
#include <gtest/gtest.h>

#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kClothFrame = 1.0 / 60;

/// n x n particles over 2 m x 2 m, hung by a row, horizontal at the start, with structural and shear springs.
Scene hung_cloth(int n, int substeps, int iterations = 1, Precision precision = Precision::Float) {
  BodySpec cloth;
  cloth.name = "cloth";
  cloth.shape = GridShape{{2, 2}, {n - 1, n - 1}};
  cloth.mass = 1;
  cloth.pins = {RowPin{}};
  cloth.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({cloth}, kEarth, kClothFrame, substeps, precision);
  scene.solver.iterations = iterations;
  return scene;
}

double rms_after_a_second(const Scene& scene) { return after(scene, 1).measure().strain_rms; }

// The bounds are the values of peers with as many projections (Jolt, sorted by colour: 0.008), plus 10 %.
TEST(HungCloth, StretchesLittleAtOneIterationAndTenSubsteps) {
  EXPECT_LT(rms_after_a_second(hung_cloth(46, 10)), 0.0085);
  EXPECT_LT(rms_after_a_second(hung_cloth(100, 10)), 0.043);
}

TEST(HungCloth, StretchesFarLessWithSubstepsThanWithAsManyIterations) {
  const double iterations = rms_after_a_second(hung_cloth(46, 1, 10)),
               substeps = rms_after_a_second(hung_cloth(46, 10));
  EXPECT_LT(substeps, iterations / 5);
  EXPECT_LT(rms_after_a_second(hung_cloth(46, 40)), substeps / 2);
}

/// Still air that damps: hanging bodies come to rest in it.
Scene at_rest_soon(BodySpec body, int substeps, double drag) {
  Scene scene = scene_of({std::move(body)}, kEarth, kClothFrame, substeps);
  scene.wind = Wind{{0, 0, 0}, drag};
  return scene;
}

TEST(HungChain, OfStiffLinksSagsAsTheCatenary) {
  const double span = 1, length = 1.3;
  double low = 0.01, high = 100;  // the catenary's parameter a, where 2 a sinh(span / 2 a) = length
  for (int bisection = 0; bisection < 100; ++bisection) {
    const double a = (low + high) / 2;
    (2 * a * std::sinh(span / 2 / a) > length ? low : high) = a;
  }
  const double sag = low * (std::cosh(span / 2 / low) - 1);
  const auto sag_error = [&](int substeps) {
    BodySpec chain = hung_chain({0, 0, 0}, {span, 0, 0}, 20, 1.0 / 21);
    chain.pins = {ListPin{{0}}, RowPin{true}};
    chain.constraints = {stiff("distance", {"edges"}, 1, length / span)};
    return -after(at_rest_soon(chain, substeps, 0.03), 20).positions()[10][1] - sag;
  };
  // One iteration lets links stretch as h^2; twenty links instead of a curve account for 3e-4 m.
  const double coarse = sag_error(10), fine = sag_error(40);
  EXPECT_LT(std::abs(coarse), 0.005);
  EXPECT_LT(std::abs(fine), 0.001);
}

TEST(HungChain, StretchesAsTheSquareOfTheSubstep) {
  const auto stretch = [](int substeps) {
    BodySpec chain = hung_chain({0, 0, 0}, {0, -1, 0}, 20, 0.05);
    chain.constraints = {stiff("distance", {"edges"})};
    return -1 - after(at_rest_soon(chain, substeps, 0.5), 10).positions()[20][1];
  };
  const double coarse = stretch(10), middle = stretch(20), fine = stretch(40);
  EXPECT_GT(coarse, 0);
  EXPECT_LT(coarse, 0.006);
  EXPECT_NEAR(coarse / middle, 4, 0.1);
  EXPECT_NEAR(middle / fine, 4, 0.1);
}

TEST(HungMass, StretchesACompliantSpringByComplianceTimesWeightExactly) {
  for (const double alpha : {1e-6, 1e-3, 0.02}) {
    BodySpec spring = hung_chain({0, 0, 0}, {0, -1, 0}, 1, 2);
    spring.constraints = {compliant("distance", alpha, {"edges"})};
    const Simulation simulation = after(at_rest_soon(spring, 4, 20), 10);
    EXPECT_NEAR(-1 - simulation.positions()[1][1], alpha * 2 * kG, 1e-12) << alpha;
    EXPECT_NEAR(simulation.measure().elastic, alpha * 4 * kG * kG / 2, 1e-9) << alpha;
  }
}

TEST(HungMass, OnManyCompliantSpringsStretchesByEachOnesShareOfWeight) {
  BodySpec chain = hung_chain({0, 0, 0}, {0, -1, 0}, 10, 0.1);
  const double alpha = 1e-3;
  chain.constraints = {compliant("distance", alpha, {"edges"})};
  const Simulation simulation = after(at_rest_soon(chain, 40, 0.5), 15);
  const double link = 0.11;  // kg: 1.1 kg shared by length, so that the end carries half a link
  double expected = 0;
  for (int spring = 1; spring <= 10; ++spring) expected += alpha * kG * link * (10.5 - spring);
  EXPECT_NEAR(-1 - simulation.positions()[10][1], expected, 0.005 * expected);  // one iteration a substep
}

TEST(DistanceLimit, HoldsWhatASoftSpringAloneWouldNot) {
  BodySpec chain = hung_chain({0, 0, 0}, {0, -1, 0}, 10, 0.1);
  chain.constraints = {compliant("distance", 0.1, {"edges"})};
  EXPECT_GT(after(at_rest_soon(chain, 40, 0.5), 15).measure().strain_max, 5);
  chain.constraints.push_back(stiff("distance_limit", {"edges"}, 1, 0.1));
  const Measures limited = after(at_rest_soon(chain, 40, 0.5), 15).measure();
  EXPECT_LT(limited.strain_max, 0.101);  // the limit, and a stiff chain's own stretch (above)
  EXPECT_GT(limited.strain_rms, 0.099);
}

class Balloon : public testing::TestWithParam<double> {};

TEST_P(Balloon, KeepsItsVolumeItsFormAndItsMomentum) {
  BodySpec balloon;
  balloon.name = "balloon";
  balloon.shape = SphereShape{0.5, 3};
  balloon.mass = 0.3;
  balloon.velocity = {1, 2, 3};
  balloon.damping = 0.1;
  balloon.constraints = {compliant("distance", 0.3, {"edges"}), stiff("bending", {}, 0.3),
                         stiff("pressure", {}, 1, GetParam())};
  const Scene scene = scene_of({balloon}, {}, kClothFrame, 10);
  Simulation simulation(scene, {.threads = 1});
  const Measures before = simulation.measure();
  run_for(simulation, scene, 3);
  const Measures now = simulation.measure();
  // Pressure is projected last, and one Newton step leaves an error of second order in the change of a substep.
  EXPECT_NEAR(now.volume_ratios.at(0), GetParam(), 1e-6);
  EXPECT_LT(length(now.momentum - before.momentum), 1e-11);
  const double radius = 0.5 * std::cbrt(GetParam());
  const double inertia = 2.0 / 3 * 0.3 * radius * radius;
  EXPECT_LT(length(now.angular_momentum) / inertia, 0.05);  // rad/s; it does not start to spin
  Vec3 centre{};
  for (int k = 0; k < 3; ++k) centre[k] = balloon.velocity[k] * simulation.time();
  for (const Vec3& x : simulation.positions()) ASSERT_NEAR(length(x - centre), radius, 0.01 * radius);
}

INSTANTIATE_TEST_SUITE_P(Pressures, Balloon, testing::Values(1, 1.2, 2));

}  // namespace
}  // namespace malha
