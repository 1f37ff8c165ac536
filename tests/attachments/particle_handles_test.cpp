// SPDX-License-Identifier: Apache-2.0
// Particle handles: pulling by a spring, holding, and releasing particles.
#include <gtest/gtest.h>

#include <cmath>

#include "host/solver/solver.h"
#include "tests/attachments/by_hand.h"
#include "tests/refusal.h"
#include "tests/support.h"

namespace malha {
namespace {

/// With steps of a second backward Euler is soon at rest, m g alpha below the point that pulls.
TEST(ParticleHandle, HangsAParticleByItsWeightTimesTheCompliance) {
  for (const char* const method : {"pbd", "desbrun"})
    for (const int iterations : {1, 4}) {
      Scene scene = scene_of({particle({0, 0, 0}, {}, 2)}, kEarth, 1.0, 1);
      scene.solver.type = method, scene.solver.iterations = iterations;
      Simulation simulation(scene, {.threads = 1, .interactive = true});
      simulation.pull(0, {3, 1, 0}, 1.0 / 800);
      run_for(simulation, scene, 30);
      const Vec3 x = simulation.positions()[0];
      EXPECT_NEAR(x[0], 3, 1e-9) << method;
      EXPECT_NEAR(x[1], 1 - 2 * kG / 800, 1e-9) << method;
      EXPECT_NEAR(simulation.measure().elastic, std::pow(2 * kG, 2) / 800 / 2, 1e-9) << "what the spring holds";
    }
}

/// The spring acts at the end of each substep, so that the impulse of n substeps is the sum of the forces measured
/// there: the body's momentum is what gravity and these forces give, whatever its constraints do.
TEST(ParticleHandle, GivesABodyTheImpulseOfItsSpringAndNothingElse) {
  for (const bool keeps : {false, true}) {
    Scene scene = two_cloths(Precision::Double);
    scene.solver.substeps = 1, scene.solver.keeps_momenta = keeps;
    scene.bodies.pop_back();
    scene.bodies[0].pins.clear(), scene.bodies[0].damping = 0.05;
    Simulation simulation(scene, {.threads = 1, .interactive = true});
    const Vec3 to{0.7, 0.4, 0.6};
    const double alpha = 1e-2;
    simulation.pull(84, to, alpha);
    Vec3 expected{0, 0, 0};
    for (int step = 0; step < 100; ++step) {
      simulation.step();
      // One substep and one projection: the force is that at the end of the step.
      const Vec3 x = simulation.positions()[84];
      for (int k = 0; k < 3; ++k) expected[k] += scene.solver.dt * (0.2 * scene.gravity[k] + (to[k] - x[k]) / alpha);
    }
    EXPECT_GT(length(expected), 0.01);
    // Rounding: 1e-16 of places near 1, over alpha, a hundred steps.
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(simulation.measure().momentum[k], expected[k], 1e-11) << "keeps " << keeps;
  }
}

TEST(ParticleHandle, LetsABodyHangInBalance) {
  Scene scene = two_cloths(Precision::Double);
  scene.bodies.pop_back();
  scene.bodies[0].pins.clear(), scene.wind = Wind{{0, 0, 0}, 0.01};
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  simulation.pull(0, {0, 0, 0}, 1e-2);
  run_for(simulation, scene, 20);
  ASSERT_LT(simulation.measure().kinetic, 1e-12) << "in still air that drags it is at rest";
  const Vec3 x = simulation.positions()[0];
  EXPECT_NEAR(x[1], -0.2 * kG * 1e-2, 1e-6) << "the whole weight times the compliance; 1e-6: the speed that is left";
}

TEST(ParticleHandle, HoldsAsAPinDoes) {
  for (const int iterations : {1, 2}) {
    Scene scene = two_cloths();
    scene.solver.iterations = iterations;
    Simulation simulation(scene, {.threads = 2, .interactive = true});
    run_for(simulation, scene, 0.1);
    simulation.hold(84);
    const Vec3 at = simulation.positions()[84];
    EXPECT_EQ(simulation.velocities()[84], (Vec3{0, 0, 0}));
    run_for(simulation, scene, 0.5);
    EXPECT_EQ(simulation.positions()[84], at);
    EXPECT_EQ(simulation.velocities()[84], (Vec3{0, 0, 0}));
    simulation.release(84);
    run_for(simulation, scene, 0.5);
    EXPECT_LT(simulation.positions()[84][1], at[1] - 0.05) << "it falls again";
  }
}

/// A pin that is released is the same as a hold that is released: the bits are the same, from then on too.
TEST(ParticleHandle, HoldsAndReleasesAsAPinThatIsReleased) {
  Scene scene = two_cloths(), pinned = scene;
  Pin released(ListPin{{84}});
  released.release_time = 0.2;
  pinned.bodies[0].pins.push_back(released);
  Simulation by_scene(pinned, {.threads = 1}), interactive(scene, {.threads = 1, .interactive = true});
  interactive.hold(84);
  for (int step = 0; step < 50; ++step) {
    if (step == 20) interactive.release(84);
    by_scene.step(), interactive.step();
    ASSERT_TRUE(same_bits(by_scene, interactive, 0, 338)) << "step " << step;
  }
}

TEST(ParticleHandle, CarriesAParticleAtASteadySpeedAndThrowsIt) {
  const Scene scene = scene_of({particle({0, 1, 0})}, {0, 0, 0}, 0.01, 4);
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  simulation.hold(0, {0.02, 1, 0.01});
  simulation.step();
  EXPECT_EQ(simulation.positions()[0], (Vec3{0.02, 1, 0.01}));
  EXPECT_NEAR(simulation.velocities()[0][0], 2, 1e-12);
  simulation.hold(0, {0.04, 1, 0.02});
  simulation.step();
  simulation.release(0);
  simulation.step();
  EXPECT_NEAR(simulation.positions()[0][0], 0.06, 1e-12) << "it flies on";
  simulation.hold(0);
  run_for(simulation, scene, 0.1);
  EXPECT_NEAR(simulation.positions()[0][0], 0.06, 1e-12) << "it stops";
  EXPECT_EQ(simulation.velocities()[0][0], 0);
}

TEST(ParticleHandle, IsListed) {
  const Scene scene = two_cloths();
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  EXPECT_TRUE(simulation.handles().empty());
  simulation.pull(84, {1, 2, 3}, 1e-3), simulation.hold(85, {0, 1, 0});
  ASSERT_EQ(simulation.handles().size(), 2u);
  EXPECT_EQ(simulation.handles()[0].particle, 84);
  EXPECT_EQ(simulation.handles()[0].to, (Vec3{1, 2, 3}));
  EXPECT_EQ(simulation.handles()[0].compliance, 1e-3);
  EXPECT_EQ(simulation.handles()[1].particle, 85);
  EXPECT_TRUE(simulation.handles()[1].is_held());
  simulation.release(84), simulation.release(3), simulation.release(-1), simulation.release(1 << 30);
  EXPECT_EQ(simulation.handles().size(), 1u);
}

TEST(ParticleHandle, WakesWhatSleepsAndKeepsItAwake) {
  Scene scene = scene_of({particle({0, 0, 0})}, {0, 0, 0}, 0.01);
  scene.sleep = Sleep{};
  scene.sleep->after = 0.05;
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  run_for(simulation, scene, 0.2);
  ASSERT_EQ(simulation.solver().sleep()->particles, 1);
  simulation.pull(0, {0, 0, 0}, 1e-3);
  run_for(simulation, scene, 0.2);
  EXPECT_EQ(simulation.solver().sleep()->particles, 0) << "nothing moves, but it is in a hand";
  simulation.release(0);
  run_for(simulation, scene, 0.2);
  EXPECT_EQ(simulation.solver().sleep()->particles, 1);
}

/// A particle is pulled from far away by a spring that is stiff for its weight, and thrown to and fro: it is fast, but
/// nothing diverges.
TEST(ParticleHandle, DoesNotTripTheEnergyGuardHoweverItPulls) {
  for (const bool holds : {false, true}) {
    const Scene scene = two_cloths();
    Simulation simulation(scene, {.threads = 1, .interactive = true});
    for (int step = 0; step < 200; ++step) {
      const Vec3 to{step % 20 < 10 ? -3.0 : 3.0, 0.2, 0.5};
      if (step % 10 == 0) holds ? simulation.hold(84, to) : simulation.pull(84, to, 1e-4);
      ASSERT_NO_THROW(simulation.step()) << "step " << step;
      ASSERT_NO_THROW(simulation.check_divergence()) << "step " << step;
    }
  }
}

TEST(ParticleHandle, RefusesParticlesThatCannotBeMoved) {
  Scene scene = two_cloths();
  Simulation none(scene, {.threads = 1});
  EXPECT_EQ(refusal([&] {
              none.pull(84, {0, 0, 0}, 1);
            }),
            "pull, hold: found a simulation without interactive; allowed: one that is made with it");
  EXPECT_TRUE(none.handles().empty());
  Simulation some(scene, {.threads = 1, .interactive = true});
  EXPECT_EQ(refusal([&] {
              some.pull(0, {0, 0, 0}, 1);
            }),
            "pull: found particle 0 of body 'left', which is pinned; allowed: one that is free");
  EXPECT_EQ(refusal([&] { some.hold(12); }),
            "hold: found particle 12 of body 'left', which is pinned; allowed: one that is free");
  EXPECT_EQ(refusal([&] { some.pull(338, {0, 0, 0}, 1); }), "pull: found particle 338; allowed: 0 to 337");
  EXPECT_EQ(refusal([&] { some.hold(-1); }), "hold: found particle -1; allowed: 0 to 337");
  for (const double compliance : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_TRUE(has(refusal([&] { some.pull(84, {0, 0, 0}, compliance); }), "allowed: 1e-12 to 1e12 m/N"));
  EXPECT_TRUE(has(refusal([&] { some.pull(84, {0, NAN, 0}, 1); }), "allowed: numbers up to 1e18"));
  some.hold(84);
  EXPECT_TRUE(has(refusal([&] { some.move_pin(84, {0, 0, 0}); }), "not pinned")) << "hold() moves it";
  some.pull(84, {0, 0, 0}, 1);  // pull() replaces the hold
  EXPECT_FALSE(some.handles().at(0).is_held());
  EXPECT_EQ(some.handles().size(), 1u);

  scene.solver.levels = 2;
  Simulation levels(scene, {.threads = 1, .interactive = true});
  EXPECT_EQ(refusal([&] { levels.hold(84); }),
            "hold: found a solver with levels, which are laid out for what is pinned; allowed: to pull");
  scene.solver.type = "desbrun";
  Simulation desbrun(scene, {.threads = 1, .interactive = true});
  EXPECT_EQ(refusal([&] { desbrun.hold(84); }),
            "hold: found a solver with Desbrun's filter, which is made for pins that stay; allowed: to pull");
}

TEST(ParticleHandle, StaysWhereTheStateToRestoreIsNone) {
  const Scene scene = two_cloths();
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  simulation.pull(84, {0, 1, 0}, 1e-3);
  const std::uint64_t before = simulation.state_hash();
  EXPECT_TRUE(has(refusal([&] { simulation.restore_state("no"); }), "state: found 2 bytes that are no state"));
  EXPECT_EQ(simulation.state_hash(), before);
  EXPECT_EQ(simulation.handles().size(), 1u);
}

/// A strip tears in its middle while a corner is pulled and another is held: both handles stay.
TEST(ParticleHandle, StaysWhereItIsWhileTheMeshTears) {
  BodySpec loose = cloth_by_hand("loose", -9, 2), strip;
  strip.name = "strip", strip.mass = 0.2;
  strip.shape = GridShape{{1, 2}, {4, 8}};
  strip.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
  strip.pins = {RowPin{false}};
  strip.tear = Tear{0.5};
  BodySpec last = cloth_by_hand("last", 9, 2);
  const Scene scene = scene_of({loose, strip, last}, {0, 0, 0}, 0.01, 4);
  Simulation simulation(scene, {.threads = 1, .interactive = true});
  const int first = 9, of_last = 9 + 45 + 4;
  simulation.pull(of_last, {10, 1, 1}, 1e-2);
  for (int i = 40; i < 45; ++i) simulation.hold(first + i);
  for (int step = 1; step <= 100; ++step) {
    for (int i = 40; i < 45; ++i) simulation.hold(first + i, {0.25 * (i - 40), 0, 2 + 0.018 * step});
    simulation.step();
  }
  const int tears = simulation.tears();
  ASSERT_GT(tears, 0);
  const std::vector<ParticleHandle> held = simulation.handles();
  ASSERT_EQ(held.size(), 6u);
  for (const ParticleHandle& one : held) {
    if (!one.is_held()) {
      EXPECT_EQ(one.particle, of_last + tears) << "all duplicates come before the last body";
      EXPECT_EQ(one.to, (Vec3{10, 1, 1}));
      continue;
    }
    EXPECT_EQ(simulation.positions()[one.particle], one.to);
    EXPECT_NEAR(one.to[2], 3.8, 1e-12);
  }
}

TEST(ParticleHandle, HoldsAVertexTogether) {
  BodySpec rope = hung_chain({0, 0, 0}, {4, 0, 0}, 4);
  rope.constraints = {stiff("distance", {"edges"})}, rope.tear = Tear{0.2};
  Simulation simulation(scene_of({rope}, {0, 0, 0}, 0.01, 10), {.threads = 1, .interactive = true});
  simulation.hold(2), simulation.hold(3, {3.5, 0, 0});  // The edge between them is strained by a half.
  for (int step = 0; step < 5; ++step) simulation.step();
  EXPECT_EQ(simulation.tears(), 0);
  simulation.release(2);
  simulation.step();
  EXPECT_GT(simulation.tears(), 0) << "the hand alone kept it";
}

}  // namespace
}  // namespace malha
