// SPDX-License-Identifier: Apache-2.0
// Bits that particle handles must not change: those of bodies that they do not touch, and those of a state that is
// restored.
#include <gtest/gtest.h>

#include <functional>

#include "host/solver/solver.h"
#include "tests/attachments/by_hand.h"

namespace malha {
namespace {

struct OfScene {
  std::string name;
  std::function<void(Scene&)> change;
};
void PrintTo(const OfScene& of, std::ostream* out) { *out << of.name; }

EnvironmentSpec floor_by_hand() {
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = BoxShape{{20, 1, 20}, {{1, 1, 1}}}, ground.friction = 0.3;
  ground.transform.translate = {-8, -1.6, -8};
  return ground;
}

class ParticleHandleIn : public testing::TestWithParam<OfScene> {};

TEST_P(ParticleHandleIn, LeavesOtherBodiesTheirBits) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene scene = two_cloths(precision);
    GetParam().change(scene);
    const std::size_t first = 13 * 13, count = 13 * 13;
    for (const int threads : {1, 2}) {
      Simulation alone(scene, {.threads = threads}), touched(scene, {.threads = threads, .interactive = true});
      for (int step = 0; step < 60; ++step) {
        if (step == 10) touched.pull(84, {0.5, 0.6, 0.5}, 1e-3);
        if (step == 25) touched.pull(84, {0.2, 0.5, 0.3}, 1e-3), touched.pull(90, {1, 1, 1}, 1e-2);
        if (step == 40) touched.release(84), touched.release(90);
        alone.step(), touched.step();
        ASSERT_TRUE(same_bits(alone, touched, first, count)) << "step " << step << ", " << threads << " threads";
        EXPECT_EQ(same_bits(alone, touched, 0, first), step < 10) << "the pulled one moves otherwise from its step on";
      }
    }
  }
}

TEST_P(ParticleHandleIn, IsUndoneToTheVerySameBits) {
  Scene scene = two_cloths();
  GetParam().change(scene);
  Simulation alone = after(scene, 0.1), touched(scene, {.threads = 1, .interactive = true});
  run_for(touched, scene, 0.1);
  const std::string state = touched.save_state();
  touched.pull(84, {0.5, 0.6, 0.5}, 1e-3);
  run_for(touched, scene, 0.1);
  EXPECT_NE(touched.save_state(), state);
  touched.restore_state(state);
  EXPECT_TRUE(touched.handles().empty());
  EXPECT_EQ(touched.save_state(), state);
  run_for(touched, scene, 0.3), run_for(alone, scene, 0.3);
  EXPECT_EQ(touched.state_hash(), alone.state_hash());
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, ParticleHandleIn,
    testing::Values(OfScene{"WholeSteps", [](Scene&) {}},
                    OfScene{"Iterated", [](Scene& s) { s.solver.iterations = 3; }},
                    OfScene{"DampedInTheWind",
                            [](Scene& s) {
                              for (BodySpec& body : s.bodies) body.damping = 0.1;
                              s.wind = Wind{{1, 0, 0}, 0.01};
                            }},
                    OfScene{"OnTheFloor", [](Scene& s) { s.environment = {floor_by_hand()}; }},
                    OfScene{"BesideEdgesOfTheFloor",
                            [](Scene& s) {
                              s.environment = {floor_by_hand()};
                              s.environment[0].edges = true, s.environment[0].transform.translate = {0.4, -1.2, 0.4};
                            }},
                    OfScene{"WithLongRangeAttachments",
                            [](Scene& s) {
                              for (BodySpec& body : s.bodies) body.constraints.push_back(stiff("long_range"));
                            }},
                    OfScene{"WithSelfCollision",
                            [](Scene& s) {
                              s.self_collision = SelfCollision{};
                              s.self_collision->thickness = 0.01;
                            }},
                    OfScene{
                        "WithLevels",
                        [](Scene& s) { s.solver.levels = 2, s.solver.levels_interval = 2, s.solver.iterations = 2; }},
                    OfScene{"FreeAndKeepingMomenta",
                            [](Scene& s) {
                              s.solver.keeps_momenta = true;
                              for (BodySpec& body : s.bodies) body.pins.clear(), body.spin = {1, 2, 3};
                            }},
                    OfScene{"FreeKeepingMomentaInTheWind",
                            [](Scene& s) {
                              s.solver.keeps_momenta = true, s.wind = Wind{{1, 0, 0}, 0.01};
                              for (BodySpec& body : s.bodies) body.pins.clear(), body.spin = {1, 2, 3};
                            }},
                    OfScene{"FreeKeepingMomentaOnTheFloor",
                            [](Scene& s) {
                              s.solver.keeps_momenta = true, s.environment = {floor_by_hand()};
                              for (BodySpec& body : s.bodies) body.pins.clear(), body.spin = {1, 2, 3};
                            }},
                    OfScene{"ByDesbrunsMethod",
                            [](Scene& s) {
                              s.solver.type = "desbrun", s.solver.substeps = 1, s.solver.iterations = 5;
                              for (BodySpec& body : s.bodies)
                                body.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
                            }}),
    [](const testing::TestParamInfo<OfScene>& tested) { return tested.param.name; });

TEST_P(ParticleHandleIn, StepsInPartsWithTheSameBits) {
  for (const bool pulled : {false, true}) {
    Scene scene = two_cloths();
    GetParam().change(scene);
    Simulation whole(scene, {.threads = 1, .interactive = true}), parts(scene, {.threads = 1, .interactive = true});
    for (int step = 0; step < 30; ++step) {
      if (pulled && step == 5) whole.pull(84, {0.5, 0.6, 0.5}, 1e-3), parts.pull(84, {0.5, 0.6, 0.5}, 1e-3);
      std::vector<double> times;
      std::vector<Vec3> last;
      whole.step();
      const auto look = [&](int substep, double time) {
        EXPECT_EQ(substep, int(times.size()) + 1);
        EXPECT_NE(parts.positions(), last) << "each substep moves something";
        times.push_back(time), last = parts.positions();
      };
      step % 3 == 1 ? parts.step() : parts.step(look);
      ASSERT_EQ(whole.state_hash(), parts.state_hash()) << "step " << step;
      if (step % 3 == 1) continue;
      ASSERT_EQ(int(times.size()), scene.solver.substeps);
      EXPECT_NEAR(times.back(), parts.time(), 1e-12);
      EXPECT_EQ(last, parts.positions());
    }
  }
}

TEST(ParticleHandle, IsNeededToStepInParts) {
  Simulation simulation(two_cloths());
  EXPECT_THROW(simulation.step([](int, double) {}), InputError);
  simulation.step();
}

TEST(ParticleHandle, ThatHoldsLeavesOtherBodiesTheirBitsToo) {
  for (const bool free : {false, true}) {
    Scene scene = two_cloths();
    scene.solver.keeps_momenta = free;
    if (free)
      for (BodySpec& body : scene.bodies) body.pins.clear(), body.spin = {1, 2, 3};
    Simulation alone(scene, {.threads = 1}), touched(scene, {.threads = 1, .interactive = true});
    for (int step = 0; step < 50; ++step) {
      if (step == 10) touched.hold(84);
      if (step > 20 && step < 30) touched.hold(84, {0.5, 0.01 * (step - 20), 0.5});
      if (step == 40) touched.release(84);
      alone.step(), touched.step();
      ASSERT_TRUE(same_bits(alone, touched, 169, 169)) << "step " << step;
    }
    EXPECT_FALSE(same_bits(alone, touched, 0, 169));
  }
}

TEST(ParticleHandle, ThatIsAllowedButUnusedChangesNoBits) {
  for (const int iterations : {1, 3}) {
    Scene scene = two_cloths();
    scene.solver.iterations = iterations, scene.solver.levels = 2;
    scene.solver.bending = BendingMethod::Projected;  // so that patch solves are fused
    Simulation touched = after(scene, 0.3, {.threads = 2, .interactive = true});
    EXPECT_TRUE(touched.solver().step_plan().fuses());
    EXPECT_EQ(touched.state_hash(), after(scene, 0.3).state_hash());
  }
}

}  // namespace
}  // namespace malha
