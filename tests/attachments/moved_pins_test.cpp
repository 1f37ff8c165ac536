// SPDX-License-Identifier: Apache-2.0
// Kinematic pins: pins that follow keyframes, and pins that are released.
#include <gtest/gtest.h>

#include <filesystem>

#include "host/attachments/pose.h"
#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

const std::vector<Keyframe> kSwing{
    {0.05, {0, 0, 0}, {0, 1, 0}, 0}, {0.2, {0.3, 0.2, 0}, {0, 0, 1}, 60}, {0.4, {-0.1, 0, 0.5}, {1, 0, 1}, 30}};

Pin moving(const Selector& at, std::vector<Keyframe> motion, std::optional<double> release_time = std::nullopt) {
  Pin pin(at);
  pin.motion = std::move(motion), pin.release_time = release_time;
  return pin;
}

Scene carried_sheet(Precision precision = Precision::Float, std::optional<double> release_time = std::nullopt) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.2;
  sheet.shape = GridShape{{1, 1}, {8, 8}};
  sheet.constraints = {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.1)};
  sheet.pins = {moving(RowPin{}, kSwing, release_time)};
  return scene_of({sheet}, kEarth, 0.01, 4, precision);
}

struct Way {
  std::string name;
  Precision precision;
  std::function<void(Scene&)> change;
};
void PrintTo(const Way& way, std::ostream* out) { *out << way.name; }

class MovedPinsOf : public testing::TestWithParam<Way> {};

TEST_P(MovedPinsOf, AreWhereTheirKeyframesSayAtTheEndOfEveryStep) {
  Scene scene = carried_sheet(GetParam().precision);
  GetParam().change(scene);
  Simulation simulation(scene, {.threads = 1});
  const std::vector<Vec3> start = simulation.positions();
  for (int step = 1; step <= 45; ++step) {
    simulation.step();
    const Pose pose = pose_at(kSwing, simulation.time());
    const std::vector<Vec3> x = simulation.positions();
    for (int i = 0; i < 9; ++i) {
      const Vector3<double> at = to_world(pose, {start[i][0], start[i][1], start[i][2]});
      // In float, positions carry its rounding.
      const double rounding = GetParam().precision == Precision::Double ? 0 : 1e-12;
      ASSERT_LE(length(x[i] - Vec3{at.x, at.y, at.z}), rounding) << "step " << step << ", particle " << i;
    }
  }
  EXPECT_LT(simulation.measure().strain_max, 0.5) << "the sheet was carried along";
}

INSTANTIATE_TEST_SUITE_P(
    Every, MovedPinsOf,
    testing::Values(Way{"Fused", Precision::Float, [](Scene&) {}}, Way{"FusedDouble", Precision::Double, [](Scene&) {}},
                    Way{"Iterated", Precision::Float, [](Scene& s) { s.solver.iterations = 3; }},
                    Way{"ToBeReleased", Precision::Float, [](Scene& s) { s.bodies[0].pins[0].release_time = 9; }},
                    Way{"WithObstacles", Precision::Float,
                        [](Scene& s) {
                          EnvironmentSpec ball;
                          ball.name = "ball", ball.shape = SphereShape{0.1, 1};
                          ball.transform.translate = {0.5, -0.3, 0.5};
                          s.environment = {ball};
                        }},
                    Way{"DampedInTheWind", Precision::Double,
                        [](Scene& s) {
                          s.bodies[0].damping = 0.1;
                          s.wind = Wind{{1, 0, 0}, 0.01};
                        }},
                    Way{"Desbrun", Precision::Float,
                        [](Scene& s) { s.solver.type = "desbrun", s.solver.substeps = 1, s.solver.iterations = 10; }}),
    [](const testing::TestParamInfo<Way>& tested) { return tested.param.name; });

TEST(MovedPins, HaveTheVelocityOfTheirMotion) {
  Scene scene = carried_sheet(Precision::Double);
  scene.bodies[0].pins = {moving(RowPin{}, {{0, {}, {}, 0}, {1, {2, -1, 0.5}, {0, 1, 0}, 0}})};
  scene.bodies[0].pins[0].motion[0].axis = {0, 1, 0};
  Simulation simulation = after(scene, 0.1);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(simulation.velocities()[4][k], (Vec3{2, -1, 0.5})[k], 1e-12);
}

/// A particle that a pin threw: after the release x = x0 + v t + g t^2 / 2; with substeps of h that is late by g h t /
/// 2.
TEST(MovedPins, ReleaseParticlesWithTheVelocityOfThePin) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const Vec3 v{1, 3, 0.5};
    BodySpec thrown = particle({0, 1, 0});
    thrown.pins = {moving(ListPin{{0}}, {{0, {}, {0, 1, 0}, 0}, {1, v, {0, 1, 0}, 0}}, 0.255)};
    const Scene scene = scene_of({thrown}, kEarth, 0.01, 10, precision);
    const Vec3 x = after(scene, 0.75).positions()[0];
    const double t = 0.75 - 0.255, tolerance = 9.81 * 0.001 * t / 2 + 1e-5;
    EXPECT_NEAR(x[0], 0.75 * v[0], 1e-5);
    EXPECT_NEAR(x[1], 1 + 0.75 * v[1] - 9.81 * t * t / 2, tolerance) << "released in the middle of a step";
    EXPECT_NEAR(x[2], 0.75 * v[2], 1e-5);
  }
}

TEST(MovedPins, WithoutKeyframesStayUntilTheyAreReleased) {
  Scene scene = carried_sheet(Precision::Float);
  scene.bodies[0].pins = {moving(RowPin{}, {}, 0.2)};
  Simulation simulation(scene, {.threads = 1});
  const Vec3 start = simulation.positions()[3];
  run_for(simulation, scene, 0.2);
  EXPECT_EQ(simulation.positions()[3], start);
  simulation.move_pin(3, {0, 7, 0});
  EXPECT_EQ(simulation.positions()[3], (Vec3{0, 7, 0})) << "held until 0.2, where the next step begins";
  simulation.step();
  EXPECT_NE(simulation.positions()[0], simulation.positions()[3]);
  EXPECT_THROW(simulation.move_pin(3, start), InputError) << "it is free now";
  EXPECT_LT(after(scene, 0.5).positions()[3][1], -0.3) << "it falls";
}

TEST(MovedPins, RefuseToBeSetBetweenStepsAsWell) {
  Simulation simulation(carried_sheet(), {.threads = 1});
  EXPECT_THROW(simulation.move_pin(0, {0, 0, 0}), InputError);
}

TEST(MovedPins, ArePlannedAndReported) {
  const Simulation simulation(carried_sheet(Precision::Float, 0.25), {.threads = 1});
  const std::string text = plan(simulation);
  EXPECT_NE(text.find("\nparticles: 81\nparticles_pinned: 9\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nmoved_pins:\n  count 9, keyframes 3, release_time 0.25 s\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n  pins: 8\n"), std::string::npos) << text;
}

std::string run_refusal(const Scene& scene) {
  return refusal([&] { Simulation(scene, {.threads = 1}); });
}

TEST(MovedPins, AreRefusedWhereTheyContradictEachOtherOrTheMethod) {
  Scene scene = carried_sheet();
  scene.file = "s.json";
  scene.bodies[0].pins.push_back(ListPin{{4}});
  EXPECT_EQ(
      run_refusal(scene),
      "s.json: /bodies/0/pins/1: found particle 4, which another pin or rigid attachment holds too; allowed: one for "
      "a particle that moves or is released");
  scene = carried_sheet(Precision::Float, 1);
  scene.file = "s.json", scene.solver.type = "desbrun";
  EXPECT_EQ(run_refusal(scene),
            "s.json: /bodies/0/pins/0/release_time: found a release under Desbrun's method, whose filter is made for "
            "pins that "
            "stay; allowed: one without it, or solver type pbd");
  scene = carried_sheet();
  scene.bodies[0].pins = {moving(BoxPin{{-9, -9, -9}, {9, 9, 9}}, kSwing)};
  EXPECT_EQ(run_refusal(scene), "") << "a body may be carried whole";
}

/// Of several patches; released after 0.1 s.
Scene large_carried_sheet(int iterations) {
  Scene scene = carried_sheet(Precision::Float, 0.1);
  scene.bodies[0].shape = GridShape{{1, 1}, {40, 40}};
  scene.solver.iterations = iterations;
  return scene;
}

INSTANTIATE_TEST_SUITE_P(
    MovedPins, SameBits,
    testing::Values(SameBitsScene{"OneIteration", [](const auto&) { return large_carried_sheet(1); }, 15, {5, 10, 12}},
                    SameBitsScene{
                        "TwoIterations", [](const auto&) { return large_carried_sheet(2); }, 15, {5, 10, 12}}),
    name_of_scene);

}  // namespace
}  // namespace malha
