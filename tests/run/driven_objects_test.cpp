// SPDX-License-Identifier: Apache-2.0
// Objects of the environment that the program moves: everything that keeps a motion follows set_pose().
#include <gtest/gtest.h>

#include <cmath>

#include "host/attachments/pose.h"
#include "host/model/model.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kDt = 0.01;  // s
constexpr int kSteps = 60;

/// Where the program puts an object at the end of a step.
RigidPose pose_after(int step) {
  const double t = kDt * step;
  return {{0.2 * std::sin(8 * t), 0.1 * (1 - std::cos(6 * t)), 0.3 * t * t}, {0, 1, 0}, 40 * t};
}

/// The same motion as keyframes at the ends of the steps.
std::vector<Keyframe> as_keyframes() {
  std::vector<Keyframe> motion;
  for (int step = 0; step <= kSteps; ++step) {
    const RigidPose pose = pose_after(step);
    motion.push_back({step * kDt, pose.translate, pose.axis, pose.degrees});
  }
  return motion;
}

EnvironmentSpec plate(const Shape& shape) {
  EnvironmentSpec object;
  object.name = "plate", object.shape = shape, object.thickness = 0.01, object.friction = 0.5;
  object.transform.translate = {0, -0.1, 0};
  return object;
}
const Shape kExactPlate = BoxShape{{2, 0.2, 2}, std::nullopt}, kMeshPlate = BoxShape{{2, 0.2, 2}, std::array{4, 1, 4}};

/// A sheet that lies on a plate.
Scene sheet_on_a_plate(const EnvironmentSpec& object) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.2, sheet.shape = GridShape{{0.6, 0.6}, {8, 8}};
  sheet.transform.translate = {-0.3, 0.02, -0.3};
  sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({sheet}, kEarth, kDt, 5, Precision::Float);
  scene.environment = {object};
  return scene;
}

Simulation by_code(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  for (int step = 1; step <= kSteps; ++step) simulation.set_pose("plate", pose_after(step)), simulation.step();
  return simulation;
}
Simulation by_keyframes(Scene scene) {
  scene.environment[0].motion = as_keyframes();
  Simulation simulation(scene, {.threads = 1});
  while (simulation.steps() < kSteps) simulation.step();
  return simulation;
}

TEST(DrivenObjects, MoveASheetWithTheBitsOfKeyframes) {
  for (const Shape& shape : {kExactPlate, kMeshPlate}) {
    const Scene scene = sheet_on_a_plate(plate(shape));
    const Simulation driven = by_code(scene);
    EXPECT_EQ(driven.state_hash(), by_keyframes(scene).state_hash());
    EXPECT_GT(length(driven.velocities()[40]), 0.1) << "the plate carries it";
    EXPECT_LT(driven.measure().penetration_max, 1e-3);
  }
}

/// The same sheet with two corners tied to the plate, one by a spring.
Scene sheet_tied_to_a_plate() {
  Scene scene = sheet_on_a_plate(plate(kMeshPlate));
  Attachment rigid, soft;
  rigid.at = ListPin{{0}}, rigid.environment = "plate";
  soft.at = ListPin{{8}}, soft.environment = "plate", soft.compliance = 1e-5;
  scene.bodies[0].attachments = {rigid, soft};
  return scene;
}

TEST(DrivenObjects, TakeWhatIsAttachedToThemAlong) {
  const Scene scene = sheet_tied_to_a_plate();
  const Simulation driven = by_code(scene);
  EXPECT_EQ(driven.state_hash(), by_keyframes(scene).state_hash());
  const Vec3 start = Simulation(scene, {.threads = 1}).positions()[0], now = driven.positions()[0];
  const RigidPose end = pose_after(kSteps);
  const Pose pose = pose_at({{0, end.translate, end.axis, end.degrees}}, 0);
  const Vector3<double> there = to_world(pose, {start[0], start[1], start[2]});
  EXPECT_NEAR(now[0], there.x, 1e-6);
  EXPECT_NEAR(now[1], there.y, 1e-6);
  EXPECT_NEAR(now[2], there.z, 1e-6);
}

TEST(DrivenObjects, KeepWhatIsAttachedWhenABodyIsLaidOutAnewLater) {
  Scene scene = sheet_tied_to_a_plate();
  scene.bodies[0].tear = Tear{10};
  Simulation simulation(scene, {.threads = 1});
  for (int step = 1; step <= 30; ++step) {
    if (step == 10) {
      EXPECT_GT(simulation.cut({{40, 41}, {49, 50}, {58, 59}}), 0);
    }
    simulation.set_pose("plate", pose_after(step)), simulation.step();
  }
  Scene whole = sheet_tied_to_a_plate();
  whole.environment[0].motion = as_keyframes();
  EXPECT_LT(length(after(whole, 30 * kDt).positions()[0] - simulation.positions()[0]), 1e-6);
}

TEST(DrivenObjects, WithEdgesLeaveOthersWithEdgesWhereTheyAre) {
  Scene scene = sheet_on_a_plate(plate(kMeshPlate));
  EnvironmentSpec second = plate(kMeshPlate);
  scene.environment[0].edges = second.edges = true;
  second.name = "second", second.transform.translate = {0, -3, 0};
  scene.environment.push_back(second);
  scene.bodies[0].transform.translate = {0.8, 0.02, -0.3};  // over an edge
  const Simulation driven = by_code(scene);
  EXPECT_EQ(driven.state_hash(), by_keyframes(scene).state_hash());
  EXPECT_EQ(driven.measure().crossings, 0);
}

TEST(DrivenObjects, WakeWhatSleepsOnThem) {
  Scene scene = sheet_on_a_plate(plate(kExactPlate));
  scene.sleep = Sleep{};
  scene.sleep->speed = 0.1, scene.sleep->after = 0.1;
  Simulation simulation(scene, {.threads = 1});
  const auto height = [&] { return simulation.positions()[40][1]; };
  while (simulation.steps() < 200) simulation.step();
  const std::uint64_t asleep = simulation.state_hash();
  simulation.step();
  ASSERT_EQ(simulation.state_hash(), asleep) << "it sleeps";
  const double before = height();
  for (int step = 1; step <= 20; ++step) simulation.set_pose("plate", {{0, 0.005 * step, 0}}), simulation.step();
  EXPECT_NEAR(height(), before + 0.1, 0.01);
}

/// A particle tied to the plate, which moves before the first callback.
TEST(DrivenObjects, MoveInTheNextSubstepIfACallbackSaysSo) {
  Scene scene = scene_of({particle({0, 0.5, 0})}, {0, 0, 0}, kDt, 5);
  Attachment tied;
  tied.at = ListPin{{0}}, tied.environment = "plate";
  scene.bodies[0].attachments = {tied};
  scene.environment = {plate(kExactPlate)};
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  const auto at = [](int substep) { return 0.001 * substep * substep; };  // m along x, after so many substeps
  simulation.set_pose("plate", {{0, 0, 0}});
  int done = 0;
  for (int step = 0; step < 4; ++step)
    simulation.step([&](int substep, double time) {
      ++done;
      EXPECT_NEAR(time, done * kDt / 5, 1e-12);
      // The whole first step is the rest that was set before it, up to the first callback.
      EXPECT_NEAR(simulation.positions()[0][0], done == 1 ? 0 : at(done), 1e-12) << substep;
      simulation.set_pose("plate", {{at(done + 1), 0, 0}});
    });
  EXPECT_EQ(done, 20);
  EXPECT_NEAR(simulation.velocities()[0][0], (at(20) - at(19)) / (kDt / 5), 1e-9);
  simulation.step();
  EXPECT_NEAR(simulation.positions()[0][0], at(21), 1e-12) << "the last motion ends in a substep, and the plate rests";
  EXPECT_NEAR(simulation.velocities()[0][0], 0, 1e-9);
}

TEST(DrivenObjects, RefuseAFirstMotionInACallbackThatTheLayoutDoesNotKnow) {
  Simulation simulation(sheet_tied_to_a_plate(), {.threads = 1, .interactive = true});
  std::string said;
  simulation.step([&](int, double) { said = refusal([&] { simulation.set_pose("plate", {{1, 0, 0}}); }); });
  EXPECT_TRUE(has(said, "set_pose: found the first motion of 'plate' in a callback")) << said;
  simulation.set_pose("plate", {{0, 0, 0}});
  simulation.step([&](int, double) { said = refusal([&] { simulation.set_pose("plate", {{0.001, 0, 0}}); }); });
  EXPECT_EQ(said, "");
}

TEST(DrivenObjects, RefuseOtherNamesAndPoses) {
  Simulation simulation(sheet_on_a_plate(plate(kExactPlate)), {.threads = 1});
  EXPECT_TRUE(has(refusal([&] { simulation.set_pose("plat", {}); }), "did you mean 'plate'?"));
  EXPECT_TRUE(has(refusal([&] { simulation.set_pose("plate", {{}, {0, 0, 0}, 10}); }), "an axis of length zero"));
  EXPECT_TRUE(has(refusal([&] { simulation.set_pose("plate", {{NAN, 0, 0}}); }), "numbers up to 1e18"));
  EXPECT_TRUE(has(refusal([&] { simulation.set_vertices("plate", {}); }), "\"animation\": \"from_code\""));
}

}  // namespace
}  // namespace malha
