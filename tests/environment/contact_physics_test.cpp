// SPDX-License-Identifier: Apache-2.0
// Contact with environment meshes against the formulas of impact, rest and Coulomb's friction.
#include <gtest/gtest.h>

#include "host/mesh/vectors.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kThickness = 0.005;

/// A square sheet about the origin, in the plane y = 0 before it is tilted by `degrees` about z: downhill is along x.
EnvironmentSpec ground(double size, double degrees = 0, Sides sides = Sides::OneSided) {
  EnvironmentSpec sheet;
  sheet.name = "ground";
  sheet.shape = GridShape{{size, size}, {4, 4}};
  const double a = degrees * kPi / 180;
  sheet.transform.translate = {-size / 2 * std::cos(a), size / 2 * std::sin(a), -size / 2};
  sheet.transform.axis = {0, 0, 1};
  sheet.transform.degrees = -degrees;
  sheet.sides = sides;
  sheet.thickness = kThickness;
  return sheet;
}

Scene on(const EnvironmentSpec& environment, const BodySpec& body, double h, int substeps = 1,
         Precision precision = Precision::Double) {
  Scene scene = scene_of({body}, kEarth, h, substeps, precision);
  scene.environment = {environment};
  return scene;
}

// Moved to the thickness of the nearest wall, each particle would be beyond the other wall.
TEST(Contact, ThickerThanAGapLeavesWhatIsBetweenTwoWallsOfOneMeshThere) {
  const TemporaryFolder folder;
  EnvironmentSpec walls;
  walls.name = "walls", walls.sides = Sides::TwoSided, walls.thickness = 0.1;
  walls.shape = MeshFile{folder.write("walls.obj",
                                      "v -1 0 -1\nv 1 0 -1.2\nv 1 0 1\nv -1.1 0 1\nv -1 0.05 -1\nv 1 0.06 -1\n"
                                      "v 1.2 0.05 1\nv -1 0.05 1\nf 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\n")};
  BodySpec cloud = body("lattice", LatticeShape{{-0.5, 0.01, -0.5}, {0.5, 0.04, 0.5}, {5, 4, 5}});
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene scene = scene_of({cloud}, {0, 0, 0}, 1.0 / 60, 10, precision);
    scene.environment = {walls};
    for (const Vec3& x : after(scene, 0.2).positions()) EXPECT_TRUE(x[1] > 0 && x[1] < 0.05) << x[1];
  }
}

TEST(Bounce, HeightsAndTimesFollowTheRestitutionAsTheTimeStepShrinks) {
  const double e = 0.8, drop = 1;
  EnvironmentSpec floor = ground(4);
  floor.restitution = e;
  const auto error = [&](double h) {
    Simulation simulation(on(floor, particle({0.1, drop + kThickness, 0.2}), h), {.threads = 1});
    const double fall = std::sqrt(2 * drop / kG);
    double worst = 0, exact_time = fall, exact_top = drop, top = 0, v_before = 0;
    for (int bounces = 0; bounces < 6;) {
      simulation.step();
      const double v = simulation.velocities()[0][1];
      top = std::max(top, simulation.positions()[0][1] - kThickness);
      if (v > 0 && v_before < 0) {
        if (bounces > 0) {
          exact_top *= e * e;
          worst = std::max(worst, std::abs(top - exact_top));
          exact_time += 2 * fall * std::pow(e, bounces);
        }
        worst = std::max(worst, std::abs(simulation.time() - exact_time));
        ++bounces;
        top = 0;
      }
      v_before = v;
    }
    return worst;
  };
  // When within a step an impact falls is random, so that errors scatter: each of the six impacts costs up to a step of
  // time, or the distance that the particle covers in it (4.4 m/s at most).
  const double coarse = error(4e-3), middle = error(1e-3), fine = error(2.5e-4);
  EXPECT_LT(coarse, 15 * 4e-3);
  EXPECT_LT(middle, 15 * 1e-3);
  EXPECT_LT(fine, 15 * 2.5e-4);
  EXPECT_LT(fine, coarse / 6);
}

TEST(Bounce, WithoutLossGoesOnForEver) {
  EnvironmentSpec floor = ground(4);
  floor.restitution = 1;
  for (const double h : {0.01, 0.001}) {
    const Scene scene = on(floor, particle({0.1, 1 + kThickness, 0.2}), h);
    Simulation simulation(scene, {.threads = 1});
    const double start = simulation.measure().energy();
    for (int second = 0; second < 20; ++second) {
      run_for(simulation, scene, 1);
      const double v = simulation.velocities()[0][1];
      // Symplectic Euler conserves E - m g h v / 2; an impact errs by the gravity of a step, m g h v, which the next
      // impact compensates.
      EXPECT_NEAR(simulation.measure().energy() - kG * h * v / 2, start, kG * h * 4.43) << h << ", " << second << " s";
    }
  }
}

TEST(Bounce, ComesToRestAtTheThickness) {
  EnvironmentSpec floor = ground(4);
  floor.restitution = 0.5;
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const Simulation simulation = after(on(floor, particle({0.1, 0.5, 0.2}), 1.0 / 60, 10, precision), 3);
    const double rounding = precision == Precision::Float ? 1e-8 : 1e-15;  // of a height of 5 mm
    EXPECT_NEAR(simulation.positions()[0][1], kThickness, rounding);
    EXPECT_LT(length(simulation.velocities()[0]), rounding * 600);
  }
}

// Coulomb's impact: the normal impulse is m (1 + e) v_n whenever within the step it occurs, the tangential one mu times
// that.
TEST(Impact, LosesSlidingInProportionToTheNormalImpulse) {
  for (const double e : {0.0, 0.5, 1.0})
    for (const double height : {0.011, 0.02, 0.031, 0.034}) {
      EnvironmentSpec floor = ground(4);
      floor.restitution = e, floor.friction = 0.3;
      Scene scene = on(floor, particle({0, kThickness + height, 0}, {2, -3, 0}), 0.01);
      scene.gravity = {};
      const Simulation simulation = after(scene, 0.02);
      const Vec3 expected{2 - 0.3 * (1 + e) * 3, 3 * e, 0};
      EXPECT_LT(length(simulation.velocities()[0] - expected), 1e-12) << e << " from " << height;
    }
}

TEST(Impact, ReflectsThePathWhereverInTheStepItCame) {
  EnvironmentSpec floor = ground(4);
  floor.restitution = 0.5;
  for (const double height : {0.011, 0.02, 0.031, 0.034}) {
    Scene scene = on(floor, particle({0, kThickness + height, 0}, {0, -3, 0}), 0.01);
    scene.gravity = {};
    const double beyond = 3 * 0.02 - height;
    EXPECT_NEAR(after(scene, 0.02).positions()[0][1], kThickness + 0.5 * beyond, 1e-12) << height;
  }
}

TEST(Impact, StopsSlidingRatherThanReversingIt) {
  EnvironmentSpec floor = ground(4);
  floor.restitution = 0.5, floor.friction = 2;
  Scene scene = on(floor, particle({0, 0.02, 0}, {2, -3, 1}), 0.01);
  scene.gravity = {};
  const Simulation simulation = after(scene, 0.02);
  EXPECT_LT(length(simulation.velocities()[0] - Vec3{0, 1.5, 0}), 1e-12);
}

TEST(Friction, StopsASlidingParticleAfterItsBrakingDistance) {
  EnvironmentSpec floor = ground(20);
  floor.friction = 0.4;
  const double h = 1e-3, speed = 5, distance = speed * speed / (2 * 0.4 * kG);
  const Simulation simulation = after(on(floor, particle({0, kThickness, 0}, {3, 0, 4}), h), 2);
  const Vec3 expected{distance * 0.6, kThickness, distance * 0.8};  // straight on along its direction
  EXPECT_LT(length(simulation.positions()[0] - expected), speed * h);
  EXPECT_LT(length(simulation.velocities()[0]), 1e-12);
}

class Ramp : public testing::TestWithParam<Precision> {
 protected:
  static constexpr double kDegrees = 30, kTime = 5, kStep = 1.0 / 60;
  static constexpr int kSubsteps = 10;
  const double a_ = kDegrees * kPi / 180;
  const Vec3 downhill_{std::cos(a_), -std::sin(a_), 0}, normal_{std::sin(a_), std::cos(a_), 0};
  const Vec3 start_{kThickness * normal_[0], kThickness* normal_[1], 0.3};

  /// The displacement from the start after kTime seconds.
  Vec3 moved(double friction) const {
    EnvironmentSpec ramp = ground(80, kDegrees);
    ramp.friction = friction;
    return after(on(ramp, particle(start_), kStep, kSubsteps, GetParam()), kTime).positions()[0] - start_;
  }
};

TEST_P(Ramp, HoldsWhatIsLessSteepThanTheAngleOfFriction) {
  const Vec3 creep = moved(1.01 * std::tan(a_));
  // Friction acts on positions, so that 3,000 substeps accumulate no error: the displacement is the rounding of the
  // start itself.
  EXPECT_LT(length(creep), GetParam() == Precision::Float ? 1e-7 : 1e-14);
}

TEST_P(Ramp, LetsSlideWhatIsSteeperWithGravityLessFriction) {
  const double mu = 0.5 * std::tan(a_), h = kStep / kSubsteps;
  const double acceleration = kG * (std::sin(a_) - mu * std::cos(a_));
  const Vec3 path = moved(mu);
  const double expected = acceleration / 2 * kTime * (kTime + h);  // symplectic Euler's
  // Float, 30 m off: a push of g h^2 = 3e-5 m is rounded to 2e-6 m, up or down alike but for a systematic part.
  EXPECT_NEAR(dot(path, downhill_), expected, GetParam() == Precision::Float ? 0.02 * expected : 1e-8);
  EXPECT_NEAR(dot(path, normal_), 0, GetParam() == Precision::Float ? 4e-6 : 1e-12);
  EXPECT_NEAR(path[2], 0, 1e-6);
}

TEST_P(Ramp, CarriesASheetAsItDoesAParticle) {
  const double mu = 0.5 * std::tan(a_), time = 1, h = kStep / kSubsteps;
  EnvironmentSpec ramp = ground(20, kDegrees);
  ramp.friction = mu;
  BodySpec sheet;
  sheet.name = "sheet";
  sheet.shape = GridShape{{0.5, 0.5}, {10, 10}};
  sheet.transform.translate = start_;
  sheet.transform.axis = {0, 0, 1};
  sheet.transform.degrees = -kDegrees;
  sheet.mass = 0.1;
  sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Simulation simulation(on(ramp, sheet, kStep, kSubsteps, GetParam()), {.threads = 1});
  const std::vector<Vec3> before = simulation.positions();
  run_for(simulation, on(ramp, sheet, kStep), time);
  const double expected = kG * (std::sin(a_) - mu * std::cos(a_)) / 2 * time * (time + h);
  const std::vector<Vec3> now = simulation.positions();
  for (std::size_t i = 0; i < now.size(); ++i)
    ASSERT_NEAR(dot(now[i] - before[i], downhill_), expected, GetParam() == Precision::Float ? 0.01 : 1e-10) << i;
}

INSTANTIATE_TEST_SUITE_P(, Ramp, testing::Values(Precision::Float, Precision::Double), [](const auto& tested) {
  return std::string(tested.param == Precision::Float ? "Float" : "Double");
});

TEST(Friction, OfAConveyorAcceleratesToItsSpeedAndNoFurther) {
  EnvironmentSpec belt = ground(40);
  belt.friction = 0.4;
  Keyframe last;
  last.time = 5, last.translate = {10, 0, 0};
  belt.motion = {Keyframe{}, last};
  const Scene scene = on(belt, particle({0, kThickness, 0}), 1.0 / 60, 10);
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 120; ++step) {
    simulation.step();
    ASSERT_NEAR(simulation.velocities()[0][0], std::min(2.0, 0.4 * kG * simulation.time()), 1e-9) << step;
    ASSERT_NEAR(simulation.positions()[0][1], kThickness, 1e-12) << step;
  }
}

TEST(Friction, OfATurningSphereCarriesWhatSticksAroundWithoutSlip) {
  EnvironmentSpec sphere;
  sphere.name = "sphere";
  sphere.shape = SphereShape{1, 4};
  sphere.thickness = 0.01, sphere.friction = 5;
  Keyframe last;
  last.time = 8, last.degrees = 8 * 360;  // about y, a turn a second
  sphere.motion = {Keyframe{}, last};
  const Scene scene = on(sphere, particle({0.3, 0.97, 0}), 1.0 / 60, 10);
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 3);
  const Vec3 settled = simulation.positions()[0];
  EXPECT_GT(std::hypot(settled[0], settled[2]), 0.25);
  run_for(simulation, scene, 4.25);
  const Vec3 turned{settled[2], settled[1], -settled[0]};       // after four and a quarter turns
  EXPECT_LT(length(simulation.positions()[0] - turned), 1e-9);  // 2,550 substeps, each a rotation by 0.01, rounded
}

class Rest : public testing::TestWithParam<Precision> {
 protected:
  double rounding() const { return GetParam() == Precision::Float ? 2e-7 : 1e-12; }
};

TEST_P(Rest, KeepsItsDistanceToASolidAndASheet) {
  EnvironmentSpec crate;
  crate.name = "crate";
  crate.shape = BoxShape{{1, 1, 1}, {{2, 2, 2}}};
  for (const EnvironmentSpec& environment : {crate, ground(1), ground(1, 0, Sides::TwoSided)}) {
    const double top = environment.name == "crate" ? 0.5 : 0;
    for (const Vec3& place : {Vec3{0.13, 0, 0.21}, Vec3{0, 0, 0}, Vec3{0.25, 0, 0}}) {  // face, corner and edge
      const Vec3 start{place[0], top + 0.02, place[2]};
      const Simulation simulation = after(on(environment, particle(start), 1.0 / 60, 10, GetParam()), 1);
      const Vec3 expected{place[0], top + environment.thickness, place[2]};
      EXPECT_LT(length(simulation.positions()[0] - expected), rounding()) << environment.name;
      EXPECT_EQ(simulation.measure().contacts, 1);
    }
  }
}

TEST_P(Rest, InAWedgeKeepsItsDistanceToBothSides) {
  Scene scene = on(ground(4, 45), particle({0.05, 0.3, 0.1}), 1.0 / 60, 10, GetParam());
  scene.environment.push_back(ground(4, -45));
  scene.environment[1].name = "the other side";
  scene.environment.back().name = "the other side";
  const Simulation simulation = after(scene, 2);
  EXPECT_LT(length(simulation.positions()[0] - Vec3{0, kThickness * std::sqrt(2), 0.1}), 3 * rounding());
}

TEST_P(Rest, OfASheetOnTheGroundIsFlatAtTheThickness) {
  BodySpec sheet;
  sheet.name = "sheet";
  sheet.shape = GridShape{{1, 1}, {20, 20}};
  sheet.transform.translate = {-0.5, 0.1, -0.5};
  sheet.transform.axis = {1, 0, 0};
  sheet.transform.degrees = 5;
  sheet.mass = 0.2;
  sheet.constraints = {stiff("distance", {"edges", "shear"})};
  EnvironmentSpec floor = ground(4);
  floor.friction = 0.5;
  const Simulation simulation = after(on(floor, sheet, 1.0 / 60, 10, GetParam()), 2);
  for (const Vec3& x : simulation.positions()) ASSERT_NEAR(x[1], kThickness, 2e-5);  // the remaining jitter is g h^2
  // Static friction keeps a particle where it is up to mu g h^2 in a substep. An edge corrects half of its error at
  // each end, and ten more particles in a row may pull at it.
  const double h = 1.0 / 600, edge = 0.05;
  EXPECT_LT(simulation.measure().strain_max, 10 * 2 * floor.friction * kG * h * h / edge);
}

INSTANTIATE_TEST_SUITE_P(, Rest, testing::Values(Precision::Float, Precision::Double), [](const auto& tested) {
  return std::string(tested.param == Precision::Float ? "Float" : "Double");
});

}  // namespace
}  // namespace malha
