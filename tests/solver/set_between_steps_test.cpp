// SPDX-License-Identifier: Apache-2.0
// State that is set between two steps: positions, velocities, pins, gravity and wind.
#include <gtest/gtest.h>

#include <limits>

#include "host/solver/solver.h"
#include "tests/attachments/by_hand.h"
#include "tests/refusal.h"
#include "tests/support.h"

namespace malha {
namespace {

TEST(SetBetweenSteps, PositionsAndVelocitiesAreThoseOfTheNextStep) {
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

TEST(SetBetweenSteps, PositionsAndVelocitiesReadBackChangeNothing) {
  const Scene scene = two_cloths();
  Simulation set(scene, {.threads = 1, .interactive = true}), alone(scene, {.threads = 1, .interactive = true});
  for (Simulation* one : {&set, &alone}) one->pull(84, {0.5, 0.6, 0.5}, 1e-3);
  for (int step = 0; step < 20; ++step) {
    set.set_positions(set.positions()), set.set_velocities(set.velocities());
    set.step(), alone.step();
  }
  EXPECT_EQ(set.state_hash(), alone.state_hash());
  EXPECT_EQ(set.handles().size(), 1u) << "what is taken stays taken";
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

/// Set before the first step, it is that of the scene, by every method and with everything that is precomputed for a
/// weight.
TEST(SetBetweenSteps, GravityIsThatOfTheScene) {
  for (const char* const kind : {"pbd", "levels", "desbrun", "floor"}) {
    Scene scene = two_cloths();
    const std::string name = kind;
    if (name == "desbrun") {
      scene.solver.type = name, scene.solver.desbrun.refinement_iterations = 1;
      for (BodySpec& body : scene.bodies) body.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
    }
    if (name == "levels") {
      scene.solver.levels = 2;
      for (BodySpec& body : scene.bodies) body.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
    }
    if (name == "floor") {
      EnvironmentSpec ground;
      ground.name = "ground", ground.shape = BoxShape{{20, 1, 20}, {{1, 1, 1}}}, ground.restitution = 0.5;
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
    simulation.step(), simulation.check_divergence();
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

/// Scenes with fused patch solves, and scenes with separate passes, which would move a pin by its velocity.
struct SetKind {
  std::string name;
  Precision precision = Precision::Double;
  friend void PrintTo(const SetKind& kind, std::ostream* out) { *out << kind.name; }
};
class SetBetweenStepsOf : public testing::TestWithParam<SetKind> {
 protected:
  Scene scene() const {
    Scene all = two_cloths(GetParam().precision);
    const std::string& name = GetParam().name;
    const auto softly = [&] {
      for (BodySpec& body : all.bodies) body.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
    };
    if (name == "desbrun") all.solver.type = name, all.solver.desbrun.refinement_iterations = 1, softly();
    if (name == "levels") all.solver.levels = 2, softly();
    if (name == "self_collision") all.self_collision.emplace().thickness = 0.01;
    if (name == "environment") {
      EnvironmentSpec ball;
      ball.name = "ball", ball.shape = SphereShape{0.1, 2}, ball.transform.translate = {0, -9, 0};
      all.environment = {ball};
    }
    return all;
  }
  static SimulationOptions options() {
    SimulationOptions all{.threads = 1};
    if (GetParam().name != "own") return all;
    UserConstraint nothing;
    nothing.particles = {40, 41};
    nothing.evaluate = [](const UserBatch& batch) {
      std::fill_n(batch.C, batch.count, 0.0), std::fill_n(batch.gradient, 2 * batch.count, Vec3{0, 0, 0});
    };
    all.constraints = {nothing};
    return all;
  }
};

TEST_P(SetBetweenStepsOf, APinStaysWhateverItsVelocityIsSetTo) {
  Simulation simulation(scene(), options());
  const std::vector<Vec3> x = simulation.positions();
  simulation.set_velocities(std::vector<Vec3>(x.size(), {0, 1, 0}));
  EXPECT_EQ(simulation.velocities()[1], (Vec3{0, 1, 0}));
  EXPECT_EQ(simulation.velocities()[0], (Vec3{0, 0, 0}));
  for (int step = 0; step < 10; ++step) simulation.step();
  for (const int pin : {0, 12, 169, 181}) {
    EXPECT_EQ(simulation.positions()[pin], x[pin]);
    EXPECT_EQ(simulation.velocities()[pin], (Vec3{0, 0, 0}));
  }
  EXPECT_NE(simulation.positions()[1], x[1]);
}

/// The run is that of a scene with these pins and that state from the start.
TEST_P(SetBetweenStepsOf, PinsThatAreSetAreThoseOfTheScene) {
  Simulation simulation(scene(), options());
  EXPECT_EQ(simulation.pins(), (std::vector<int>{0, 12, 169, 181}));
  for (int step = 0; step < 10; ++step) simulation.step();
  const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
  simulation.set_pins({181, 90, 0, 90, 169});
  EXPECT_EQ(simulation.pins(), (std::vector<int>{0, 90, 169, 181}));
  EXPECT_EQ(simulation.positions(), x);
  EXPECT_EQ(simulation.steps(), 10);
  EXPECT_EQ(simulation.inverse_masses()[90], 0);
  EXPECT_GT(simulation.inverse_masses()[12], 0);
  Scene other = scene();
  other.bodies[0].pins = {ListPin{{0, 90}}};
  Simulation of_scene(other, options());
  of_scene.set_positions(x), of_scene.set_velocities(v);
  for (int step = 0; step < 20; ++step) simulation.step(), of_scene.step();
  EXPECT_EQ(simulation.state_hash(), of_scene.state_hash());
  EXPECT_EQ(simulation.positions()[90], x[90]) << "it is pinned in flight";
}

INSTANTIATE_TEST_SUITE_P(Kinds, SetBetweenStepsOf,
                         testing::Values(SetKind{"plain"}, SetKind{"levels"}, SetKind{"desbrun"},
                                         SetKind{"self_collision"}, SetKind{"environment"}, SetKind{"own"},
                                         SetKind{"plain", Precision::Float}, SetKind{"desbrun", Precision::Float},
                                         SetKind{"own", Precision::Float}),
                         [](const auto& info) {
                           return info.param.name + (info.param.precision == Precision::Float ? "_float" : "");
                         });

TEST(SetBetweenSteps, PinsOnKeyframesKeepTheirPath) {
  const Scene scene = load_shipped("turning_flag");
  Simulation set(scene, {.threads = 1}), alone(scene, {.threads = 1});
  std::vector<Vec3> v;
  for (int step = 0; step < 20; ++step) {
    v = set.velocities();
    set.set_velocities(v);
    EXPECT_EQ(set.velocities(), v);
    set.step(), alone.step();
  }
  EXPECT_EQ(set.state_hash(), alone.state_hash());
  EXPECT_TRUE(set.pins().empty());
  std::size_t pin = 0;
  while (set.inverse_masses()[pin] > 0) ++pin;
  EXPECT_TRUE(has(refusal([&] { set.set_pins({int(pin)}); }),
                  "which an attachment or a pin on keyframes or with a release holds or has held"));
}

TEST(SetBetweenSteps, AReleasedSheetFallsFreely) {
  Scene scene = scene_of({cloth_by_hand("sheet", 0)}, kEarth, 0.01, 4);
  scene.bodies[0].constraints.clear();
  Simulation simulation(scene, {.threads = 1});
  simulation.set_velocities(std::vector<Vec3>(169, {0, 0, 0}));
  simulation.set_pins({});
  const double mass = 1 / simulation.inverse_masses()[0];
  EXPECT_NEAR(mass, 0.2 / 144 / 4, 1e-12) << "a corner has a quarter of a cell";
  for (int step = 0; step < 50; ++step) simulation.step();
  EXPECT_NEAR(simulation.velocities()[0][1], -kG * 0.5, 1e-9);
  EXPECT_NEAR(simulation.positions()[0][1], -kG / 2 * 0.5 * (0.5 + 0.0025), 1e-9) << "200 substeps of g h^2";
}

TEST(SetBetweenSteps, RefusesPinsThatCannotBe) {
  Scene scene = two_cloths();
  scene.bodies[1].tear = Tear{5};
  Simulation simulation(scene, {.threads = 1});
  const std::uint64_t before = simulation.state_hash();
  EXPECT_EQ(refusal([&] { simulation.set_pins({338}); }), "pins: found particle 338; allowed: 0 to 337");
  EXPECT_EQ(simulation.pins(), (std::vector<int>{0, 12, 169, 181}));
  EXPECT_EQ(simulation.state_hash(), before);
  std::vector<Edge> knife;
  for (int i = 0; i < 13; ++i) knife.push_back({169 + 78 + i, 169 + 91 + i});
  simulation.cut(knife);
  EXPECT_TRUE(has(refusal([&] { simulation.set_pins({0}); }), "pins: found a scene that has torn"));
}

/// Other state that was set before does not matter either.
TEST(SetBetweenSteps, CheckpointsAreForTheGravityAndPinsOfTheStart) {
  const Scene scene = two_cloths();
  const TemporaryFolder folder;
  Simulation set(scene, {.threads = 1});
  set.set_gravity({0, -1, 0}), set.step(), set.save_checkpoint(folder / "c");
  Simulation other(scene, {.threads = 1});
  other.load_checkpoint(folder / "c");
  other.set_gravity({0, -1, 0});
  set.step(), other.step();
  EXPECT_EQ(set.state_hash(), other.state_hash());
  set.set_pins({0}), set.step(), set.save_checkpoint(folder / "p");
  const std::string state = set.save_state();
  EXPECT_TRUE(has(refusal([&] { other.load_checkpoint(folder / "p"); }), "a checkpoint of another scene"));
  EXPECT_TRUE(has(refusal([&] { other.restore_state(state); }), "a state of another scene"));
  other.set_pins({0}), other.load_checkpoint(folder / "p");
  set.step(), other.step();
  EXPECT_EQ(set.state_hash(), other.state_hash());
  set.set_pins({0, 12, 169, 181}), set.set_gravity(scene.gravity), set.save_checkpoint(folder / "back");
  Simulation fresh(scene, {.threads = 1});
  fresh.load_checkpoint(folder / "back");
  set.step(), fresh.step();
  EXPECT_EQ(set.state_hash(), fresh.state_hash());
}

TEST(SetBetweenSteps, NewPositionsLetADivergedSimulationGoOn) {
  Scene scene = scene_of({particle({0, 1, 0}, {1e18, 0, 0})}, {0, 0, 0}, 1e18, 1, Precision::Float);
  Simulation simulation(scene, {.threads = 1});
  const TemporaryFolder folder;
  EXPECT_THROW(run_for(simulation, scene, 1e21), Diverged) << "beyond the largest float at the 341st step";
  EXPECT_TRUE(has(refusal([&] { simulation.save_checkpoint(folder / "c"); }), "is not finite"));
  EXPECT_TRUE(has(refusal([&] { simulation.set_velocities({{0, 0, 0}}); }), "to set positions first"));
  simulation.set_positions({{1, 2, 3}}), simulation.set_velocities({{0, 0, 0}});
  simulation.step();
  EXPECT_EQ(simulation.positions()[0], (Vec3{1, 2, 3}));
}

TEST(SetBetweenSteps, AFreeBodyThatDivergedGoesBackWithTheSameBits) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {3, 3}}, sheet.mass = 1, sheet.velocity = {1e18, 0, 0};
  sheet.constraints = {stiff("distance", {"edges"})};
  Scene scene = scene_of({sheet}, {0, 0, 0}, 1e18, 1, Precision::Float);
  scene.solver.keeps_momenta = true;
  Simulation diverged(scene, {.threads = 1}), fresh(scene, {.threads = 1});
  const std::string start = diverged.save_state();
  EXPECT_THROW(run_for(diverged, scene, 1e21), Diverged);
  diverged.restore_state(start);
  for (int step = 0; step < 3; ++step) {
    diverged.step(), fresh.step();
    EXPECT_EQ(diverged.state_hash(), fresh.state_hash()) << step;
  }
}

}  // namespace
}  // namespace malha
