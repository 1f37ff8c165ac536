// What is set between two steps: places, velocities, pins, gravity and wind.
#include <gtest/gtest.h>

#include <limits>

#include "host/solver/solver.h"
#include "tests/by_hand.h"
#include "tests/refusal.h"
#include "tests/support.h"

namespace malha {
namespace {

TEST(SetBetweenSteps, PlacesAndVelocitiesAreThoseOfTheNextStep) {
  const Scene scene = scene_of({particle({0, 0, 0}), particle({1, 0, 0})}, {0, 0, 0}, 0.1);
  Scene named = scene;
  named.bodies[1].name = "other";
  Simulation simulation(named, {.threads = 1});
  simulation.set_positions({{1, 2, 3}, {4, 5, 6}});
  simulation.set_velocities({{1, 0, 0}, {0, 0, -2}});
  EXPECT_EQ(simulation.positions()[1], (Vec3{4, 5, 6})) << "velocities leave the places";
  simulation.step();
  EXPECT_NEAR(length(simulation.positions()[0] - Vec3{1.1, 2, 3}), 0, 1e-12);
  EXPECT_NEAR(length(simulation.positions()[1] - Vec3{4, 5, 5.8}), 0, 1e-12);
  EXPECT_EQ(simulation.steps(), 1);
}

TEST(SetBetweenSteps, TheOwnPlacesAndVelocitiesChangeNothing) {
  const Scene scene = two_cloths();
  Simulation set(scene, {.threads = 1, .by_hand = true}), alone(scene, {.threads = 1, .by_hand = true});
  for (Simulation* one : {&set, &alone}) one->pull(84, {0.5, 0.6, 0.5}, 1e-3);
  for (int step = 0; step < 20; ++step) {
    set.set_positions(set.positions()), set.set_velocities(set.velocities());
    set.step(), alone.step();
  }
  EXPECT_EQ(set.state_hash(), alone.state_hash());
  EXPECT_EQ(set.held().size(), 1u) << "what is taken stays taken";
}

TEST(SetBetweenSteps, PinsStayWhereTheyArePut) {
  const Scene scene = two_cloths();
  Simulation simulation(scene, {.threads = 1});
  std::vector<Vec3> x = simulation.positions();
  for (Vec3& one : x) one[1] += 1;
  simulation.set_positions(x);
  simulation.step();
  EXPECT_EQ(simulation.positions()[0], x[0]);
  EXPECT_EQ(simulation.inverse_masses()[0], 0);
  EXPECT_GT(simulation.inverse_masses()[1], 0);
  simulation.move_pins({0, 12}, {{0, 2, 0}, {1, 2, 0}});
  EXPECT_EQ(simulation.positions()[12], (Vec3{1, 2, 0}));
  EXPECT_TRUE(has(refusal([&] {
                    simulation.move_pins({0, 13}, {{9, 9, 9}, {9, 9, 9}});
                  }),
                  "particle 13, which is not"));
  EXPECT_EQ(simulation.positions()[0], (Vec3{0, 2, 0})) << "none moves where one cannot";
}

TEST(SetBetweenSteps, RefusesWhatIsNoStateOfIts) {
  Simulation simulation(two_cloths(), {.threads = 1});
  const std::uint64_t before = simulation.state_hash();
  std::vector<Vec3> x = simulation.positions();
  x[7][1] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal([&] { simulation.set_positions(x); }), "positions: row 7: found inf; allowed: numbers up to 1e18");
  x.pop_back();
  EXPECT_EQ(refusal([&] { simulation.set_velocities(x); }), "velocities: found 337 rows; allowed: 338, one a particle");
  EXPECT_EQ(refusal([&] {
              simulation.set_gravity({0, NAN, 0});
            }),
            "gravity: row 0: found nan; allowed: numbers up to 1e18");
  EXPECT_EQ(refusal([&] {
              simulation.set_wind({1, 0, 0});
            }),
            "set_wind: found a scene without wind; allowed: one that names it: air is laid out at the start");
  EXPECT_EQ(simulation.state_hash(), before);
}

/// Set before the first step it is that of the scene, by every method and with what is laid out for a weight.
TEST(SetBetweenSteps, GravityIsThatOfTheScene) {
  for (const char* const kind : {"pbd", "levels", "desbrun", "floor"}) {
    Scene scene = two_cloths();
    const std::string name = kind;
    if (name == "desbrun") {
      scene.solver.type = name, scene.solver.desbrun.refine = 1;
      for (BodySpec& body : scene.bodies) body.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
    }
    if (name == "levels") {
      scene.solver.levels = 2;
      for (BodySpec& body : scene.bodies) body.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
    }
    if (name == "floor") {
      EnvironmentSpec ground;
      ground.name = "ground", ground.shape = BoxShape{{20, 1, 20}, {1, 1, 1}}, ground.restitution = 0.5;
      ground.transform.translate = {0, -0.6, 0};
      scene.environment = {ground};
    }
    Scene without = scene;
    without.gravity = {1, 0, 0.5};
    Simulation set(without, {.threads = 1}), of_scene(scene, {.threads = 1});
    EXPECT_EQ(set.solver().facts().levels.empty(), name != "levels");
    set.set_gravity(scene.gravity);
    for (int step = 0; step < 40; ++step) set.step(), of_scene.step();
    EXPECT_EQ(set.state_hash(), of_scene.state_hash()) << kind;
    EXPECT_EQ(set.steps(), 40);
  }
}

TEST(SetBetweenSteps, GravityAndWindThatChangeAreNoExplosion) {
  Scene scene = two_cloths();
  scene.gravity = {0, 0, 0}, scene.wind = Wind{{0, 0, 0}, 0.01, 1.2};
  for (BodySpec& body : scene.bodies) body.pins.clear();
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 200; ++step) {
    if (step == 50) simulation.set_gravity({0, -50, 0});
    if (step == 100) simulation.set_wind({80, 0, 0});
    if (step == 150) simulation.set_gravity({0, 50, 0});
    simulation.step(), simulation.check();
  }
  EXPECT_GT(simulation.velocities()[0][0], 1);
}

TEST(SetBetweenSteps, WindIsThatOfTheScene) {
  Scene scene = two_cloths();
  scene.wind = Wind{{2, 0, 1}, 0.01, 1.2};
  Scene calm = scene;
  calm.wind->velocity = {0, 0, 0};
  Simulation set(calm, {.threads = 1}), of_scene(scene, {.threads = 1});
  set.set_wind({2, 0, 1});
  for (int step = 0; step < 20; ++step) set.step(), of_scene.step();
  EXPECT_EQ(set.state_hash(), of_scene.state_hash());
}

TEST(SetBetweenSteps, CheckpointsAreForTheGravityThatIsSet) {
  const Scene scene = two_cloths();
  const TemporaryFolder folder;
  Simulation set(scene, {.threads = 1});
  set.set_gravity({0, -1, 0}), set.step(), set.save_checkpoint(folder / "c");
  Simulation other(scene, {.threads = 1});
  EXPECT_TRUE(has(refusal([&] { other.load_checkpoint(folder / "c"); }), "a checkpoint of another scene"));
  other.set_gravity({0, -1, 0}), other.load_checkpoint(folder / "c");
  set.step(), other.step();
  EXPECT_EQ(set.state_hash(), other.state_hash());
}

}  // namespace
}  // namespace malha
