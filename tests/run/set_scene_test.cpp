// SPDX-License-Identifier: Apache-2.0
// Scenes that are replaced while they run: other materials, and bodies that are added and removed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/refusal.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// A sheet of 0.2 kg and 81 particles that hangs from two corners.
BodySpec hung_square(const std::string& name, const Vec3& at, double compliance = 1e-3) {
  BodySpec body;
  body.name = name, body.mass = 0.2, body.shape = GridShape{{0.8, 0.8}, {8, 8}};
  body.transform.translate = at;
  body.pins = {ListPin{{0, 8}}};
  body.constraints = {compliant("distance", compliance, {"edges", "shear"})};
  return body;
}
Scene scene_of_squares(std::vector<BodySpec> bodies) { return scene_of(std::move(bodies), kEarth, 0.01, 5); }

std::vector<Vec3> of_square(const std::vector<Vec3>& all, std::size_t body) {
  const auto first = all.begin() + static_cast<std::ptrdiff_t>(81 * body);
  return {first, first + 81};
}

TEST(SetScene, OfTheSameSettingsGoesOnAsIfNothingHadHappened) {
  const Scene scene = scene_of_squares({hung_square("a", {0, 0, 0})});
  Simulation set = after(scene, 0.3), alone = after(scene, 0.3);
  set.set_scene(set.scene());
  EXPECT_EQ(set.state_hash(), alone.state_hash());
  EXPECT_EQ(set.steps(), alone.steps());
  for (int step = 0; step < 20; ++step) set.step(), alone.step();
  EXPECT_EQ(set.state_hash(), alone.state_hash());
}

TEST(SetScene, ASmallChangeOfAMaterialIsNoJump) {
  Simulation simulation = after(scene_of_squares({hung_square("a", {0, 0, 0})}), 3);  // at rest but for a small swing
  const std::vector<Vec3> x = simulation.positions();
  simulation.step();
  double usual = 0, changed = 0;
  for (std::size_t i = 0; i < x.size(); ++i) usual = std::max(usual, length(simulation.positions()[i] - x[i]));
  Scene scene = simulation.scene();
  scene.bodies[0].constraints[0].compliance = 1.02e-3, scene.bodies[0].mass = 0.202;
  const std::vector<Vec3> before = simulation.positions();
  simulation.set_scene(scene);
  EXPECT_EQ(simulation.positions(), before);
  EXPECT_NEAR(1 / simulation.inverse_masses()[40], 0.202 / 64, 1e-12);
  simulation.step();
  for (std::size_t i = 0; i < x.size(); ++i) changed = std::max(changed, length(simulation.positions()[i] - before[i]));
  EXPECT_LT(changed, usual + 1e-4);  // m: the new place of rest is 2 mm away, where it arrives later
}

TEST(SetScene, ALargeChangeLeadsToTheEquilibriumOfTheNewScene) {
  BodySpec weight = hung_chain({0, 0, 0}, {0, -1, 0}, 1, 2);  // 2 kg
  weight.constraints = {compliant("distance", 1e-2, {"edges"})};
  Scene scene = scene_of_squares({weight});
  Simulation simulation = after(scene, 1);
  // It oscillates about its place of rest, with periods of 0.89 s and then 0.49 s.
  const auto middle = [&simulation] {
    double low = 0, high = -2;
    for (int step = 0; step < 100; ++step) {
      simulation.step();
      low = std::min(low, simulation.positions()[1][1]), high = std::max(high, simulation.positions()[1][1]);
    }
    return (low + high) / 2;
  };
  EXPECT_NEAR(middle(), -1 - 2 * kG * 1e-2, 5e-3);
  scene.bodies[0].constraints[0].compliance = 2e-3, scene.bodies[0].mass = 6;
  simulation.set_scene(scene);
  EXPECT_NEAR(middle(), -1 - 3 * kG * 2e-3, 5e-3);
}

TEST(SetScene, BodiesThatStayKeepTheirStateWhereOthersAreAddedAndRemoved) {
  const BodySpec a = hung_square("a", {0, 0, 0}), b = hung_square("b", {2, 0, 0}), c = hung_square("c", {4, 0, 0});
  Simulation simulation = after(scene_of_squares({a, b}), 0.3, {.threads = 1, .interactive = true});
  simulation.pull(81 + 40, {2.4, 0.5, 0}, 1e-2);
  std::vector<Vec3> forces(162, Vec3{0, 0, 0});
  forces[81 + 44] = {0, 0, 1};
  simulation.set_forces(forces);
  const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
  simulation.set_scene(scene_of_squares({c, b}));
  EXPECT_EQ(of_square(simulation.positions(), 1), of_square(x, 1));
  EXPECT_EQ(of_square(simulation.velocities(), 1), of_square(v, 1));
  EXPECT_EQ(of_square(simulation.positions(), 0), of_square(Simulation(scene_of_squares({c})).positions(), 0));
  EXPECT_NEAR(simulation.time(), 0.3, 1e-9);
  ASSERT_EQ(simulation.handles().size(), 1u);
  EXPECT_EQ(simulation.handles()[0].particle, 81 + 40);
  // The one that stays moves as if nothing had happened to the others.
  Simulation alone = after(scene_of_squares({b}), 0.3, {.threads = 1, .interactive = true});
  alone.pull(40, {2.4, 0.5, 0}, 1e-2);
  alone.set_forces(of_square(forces, 1));
  run_for(simulation, simulation.scene(), 0.2), run_for(alone, alone.scene(), 0.2);
  const std::vector<Vec3> now = of_square(simulation.positions(), 1), wanted = alone.positions();
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_LT(length(now[i] - wanted[i]), 1e-9);
}

TEST(SetScene, KeepsBodiesThatLieOnEachOtherApart) {
  BodySpec below = hung_square("below", {0, 0, 0}), above = hung_square("above", {0, 0.02, 0}),
           more = hung_square("more", {0, 0.2, 0});
  for (BodySpec* one : {&below, &above, &more}) one->pins.clear();
  below.pins = {ListPin{{0, 8, 72, 80}}};
  Scene scene = scene_of_squares({below, above});
  scene.self_collision.emplace().thickness = 0.01;
  Simulation simulation = after(scene, 0.5);
  scene.bodies.push_back(more);
  simulation.set_scene(scene);
  for (int step = 0; step < 60; ++step) simulation.step();
  simulation.count_crossings();
  EXPECT_EQ(simulation.measure().crossings, 0);
  EXPECT_LT(simulation.positions()[162 + 40][1], 0.15) << "the new one has fallen onto the others";
}

TEST(SetScene, LeavesEverythingAsItIsWhereItIsRefused) {
  const Scene scene = scene_of_squares({hung_square("a", {0, 0, 0})});
  Simulation simulation = after(scene, 0.1);
  const std::uint64_t before = simulation.state_hash();
  Scene wrong = scene;
  wrong.bodies[0].pins = {ListPin{{1000}}};
  EXPECT_NE(refusal([&] { simulation.set_scene(wrong); }), "");
  EXPECT_EQ(simulation.state_hash(), before);
  simulation.step();
}

TEST(SetScene, MakesCheckpointsOfTheSceneBeforeThoseOfAnotherOne) {
  Simulation simulation = after(scene_of_squares({hung_square("a", {0, 0, 0})}), 0.1);
  const std::string state = simulation.save_state();
  simulation.set_scene(scene_of_squares({hung_square("a", {0, 0, 0}, 2e-3)}));
  EXPECT_NE(refusal([&] { simulation.restore_state(state); }), "");
  const std::string now = simulation.save_state();
  Simulation same(scene_of_squares({hung_square("a", {0, 0, 0}, 2e-3)}), {.threads = 1});
  same.restore_state(now);
  EXPECT_EQ(same.state_hash(), simulation.state_hash());
}

}  // namespace
}  // namespace malha
