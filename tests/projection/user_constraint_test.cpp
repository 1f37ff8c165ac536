// SPDX-License-Identifier: Apache-2.0
// User constraints: the same physics as the built-in ones, and unchanged bits of all other bodies.
#include <gtest/gtest.h>

#include <cmath>

#include "host/solver/solver.h"
#include "tests/attachments/by_hand.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/support.h"

namespace malha {
namespace {

/// |x1 - x0| - rest.
UserConstraint own_distance(std::vector<int> pairs, double rest, double compliance = 0) {
  UserConstraint own;
  own.name = "rod", own.particles = std::move(pairs), own.compliance = compliance;
  own.evaluate = [rest](const UserBatch& batch) {
    for (int c = 0; c < batch.count; ++c) {
      const Vec3 d = batch.x[2 * c + 1] - batch.x[2 * c];
      const double l = length(d);
      batch.C[c] = l - rest;
      for (int k = 0; k < 3; ++k) batch.gradient[2 * c][k] = -d[k] / l, batch.gradient[2 * c + 1][k] = d[k] / l;
    }
  };
  return own;
}

/// A chain of one or more links of 0.5 m that starts level; without its own constraints if `bare`.
Scene swinging_chain(int links, bool bare, std::optional<double> compliance, int iterations) {
  BodySpec chain = hung_chain({0, 0, 0}, {0.5 * links, 0, 0}, links);
  if (!bare)
    chain.constraints = {compliance ? compliant("distance", *compliance, {"edges"}) : stiff("distance", {"edges"})};
  Scene scene = scene_of({chain}, kEarth, 0.01, 8);
  scene.solver.iterations = iterations;
  return scene;
}

/// One constraint has only one order, so that the difference is rounding alone.
TEST(UserConstraint, SwingsARodAsTheBuiltInDistanceDoes) {
  for (const std::optional<double> compliance : {std::optional<double>{}, std::optional<double>{1e-4}})
    for (const int iterations : {1, 5}) {
      const Simulation built = after(swinging_chain(1, false, compliance, iterations), 1);
      SimulationOptions options{.threads = 1};
      options.constraints = {own_distance({0, 1}, 0.5, compliance.value_or(0))};
      const Simulation own = after(swinging_chain(1, true, compliance, iterations), 1, options);
      EXPECT_NEAR(length(own.positions()[1] - built.positions()[1]), 0, 1e-10) << iterations;
      EXPECT_NEAR(own.measure().elastic, built.measure().elastic, 1e-10);
    }
}

/// Constraints that share a particle are coloured and swept as built-in ones.
TEST(UserConstraint, SwingsAChainAsTheBuiltInDistanceDoes) {
  const Simulation built = after(swinging_chain(6, false, {}, 20), 0.5);
  SimulationOptions options{.threads = 1};
  options.constraints = {own_distance({0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6}, 0.5)};
  const Simulation own = after(swinging_chain(6, true, {}, 20), 0.5, options);
  for (int i = 0; i <= 6; ++i) EXPECT_NEAR(length(own.positions()[i] - built.positions()[i]), 0, 0.01) << i;
  EXPECT_EQ(own.solver().facts().user_constraints.at(0).batches, 2);
}

TEST(UserConstraint, HangsAWeightByItsCompliance) {
  BodySpec pair;
  pair.name = "pair", pair.shape = MeshDataShape{{{0, 0, 0}, {0, -1, 0}}, {}, {}, {}}, pair.mass = 4;
  pair.pins = {ListPin{{0}}};
  const Scene scene = scene_of({pair}, kEarth, 0.05, 1);
  SimulationOptions options{.threads = 1};
  options.constraints = {own_distance({0, 1}, 1, 1e-3)};
  const Simulation hung = after(scene, 60, options);
  EXPECT_NEAR(hung.constraint_values(0).at(0), 2 * kG * 1e-3, 1e-9) << "m g alpha";
  EXPECT_NEAR(hung.measure().elastic, std::pow(2 * kG, 2) * 1e-3 / 2, 1e-9);
}

class UserConstraintIn : public testing::TestWithParam<int> {};

/// Pulls corners of the left cloth together; the right one has no such constraints.
TEST_P(UserConstraintIn, LeavesOtherBodiesTheirBitsOnAnyThreads) {
  Scene scene = two_cloths(Precision::Float);
  if (GetParam() == 1) scene.solver.levels = 2, scene.solver.iterations = 2;
  if (GetParam() == 2) {
    scene.solver.keeps_momenta = true;
    for (BodySpec& body : scene.bodies) body.pins.clear(), body.spin = {1, 2, 3};
  }
  if (GetParam() == 3) scene.wind = Wind{{1, 0, 0}, 0.01};
  if (GetParam() == 4) {
    scene.solver.type = "desbrun", scene.solver.iterations = 3;
    for (BodySpec& body : scene.bodies) body.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
  }
  std::optional<std::uint64_t> hash;
  for (const int threads : {1, 2}) {
    SimulationOptions options{.threads = threads};
    options.constraints = {own_distance({156, 168, 84, 90}, 0.3, 1e-3)};
    Simulation alone(scene, {.threads = threads}), pulled(scene, options);
    for (int step = 0; step < 40; ++step) {
      alone.step(), pulled.step();
      ASSERT_TRUE(same_bits(alone, pulled, 169, 169)) << "step " << step << ", " << threads << " threads";
    }
    EXPECT_FALSE(same_bits(alone, pulled, 0, 169));
    EXPECT_EQ(pulled.state_hash(), hash.value_or(pulled.state_hash()));
    hash = pulled.state_hash();
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes, UserConstraintIn, testing::Range(0, 5));

TEST(UserConstraint, ThatThrowsLeavesTheStateBeforeTheStep) {
  const Scene scene = swinging_chain(2, true, {}, 1);
  int left = 60;
  UserConstraint own = own_distance({0, 1, 1, 2}, 0.5);
  own.evaluate = [&left, inner = own.evaluate](const UserBatch& batch) {
    if (left-- == 0) throw std::logic_error("enough");
    inner(batch);
  };
  SimulationOptions options{.threads = 1};
  options.constraints = {own};
  Simulation simulation(scene, options);
  // Two batches are evaluated twice in each of eight substeps, so that the second step throws.
  simulation.step();
  const std::uint64_t before = simulation.state_hash();
  EXPECT_THROW(simulation.step(), std::logic_error);
  EXPECT_EQ(simulation.state_hash(), before);
  EXPECT_EQ(simulation.steps(), 1);
}

TEST(UserConstraint, KeepsItsParticlesWhereBodiesBeforeItTear) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.2, sheet.shape = GridShape{{1, 2}, {4, 8}};
  sheet.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
  Pin end(RowPin{true});
  end.motion = {{0, {}, {0, 1, 0}, 0}, {1, {0, 0, 1.8}, {0, 1, 0}, 0}};
  sheet.pins = {RowPin{false}, end}, sheet.damping = 0.1, sheet.tear = Tear{0.5};
  const Scene scene = scene_of({sheet, hung_chain({5, 0, 0}, {5.5, 0, 0}, 1)}, kEarth, 0.01, 4, Precision::Float);
  SimulationOptions options{.threads = 1};
  options.constraints = {own_distance({45, 46}, 0.5)};
  Simulation torn(scene, options);
  const std::string start = torn.save_state();
  run_for(torn, scene, 1);
  ASSERT_GT(torn.tears(), 0);
  EXPECT_NEAR(torn.constraint_values(0).at(0), 0, 1e-4) << "the rod is as long as ever";
  torn.restore_state(start);
  EXPECT_EQ(torn.tears(), 0);
  run_for(torn, scene, 0.1);
  EXPECT_NEAR(torn.constraint_values(0).at(0), 0, 1e-4);
}

TEST(UserConstraint, MayGiveEnergyAsAMotorDoes) {
  Scene scene = scene_of({particle({0, 0, 0}), particle({1, 0, 0})}, {0, 0, 0}, 0.01, 1);
  scene.bodies[1].name = "other";
  SimulationOptions options{.threads = 1};
  double rest = 1;
  UserConstraint own = own_distance({0, 1}, 1);
  own.evaluate = [&rest](const UserBatch& batch) { own_distance({0, 1}, rest).evaluate(batch); };
  options.constraints = {own};
  Simulation simulation(scene, options);
  for (int step = 0; step < 100; ++step) rest += 10, simulation.step(), simulation.check_divergence();
  EXPECT_NEAR(simulation.positions()[1][0] - simulation.positions()[0][0], rest, 1e-9);
}

TEST(UserConstraint, IsRefusedWithItsNameAndPlace) {
  const Scene scene = swinging_chain(2, true, {}, 1);
  const auto refused = [&](const UserConstraint& own) {
    SimulationOptions options{.threads = 1};
    options.constraints = {own};
    return refusal([&] { Simulation(scene, options).step(); });
  };
  EXPECT_EQ(refused(own_distance({0, 3}, 1)),
            "constraint 'rod': particles: found particle 3 in constraint 0; allowed: 0 to 2");
  EXPECT_EQ(refused(own_distance({0, 1, 2, 2}, 1)),
            "constraint 'rod': particles: found particle 2 twice in constraint 1; allowed: different ones");
  EXPECT_EQ(refused(own_distance({0, 1, 2}, 1)),
            "constraint 'rod': particles: found 3 numbers; allowed: some, 2 a constraint");
  EXPECT_EQ(refused(own_distance({0, 1}, 1, -1)),
            "constraint 'rod': compliance: found -1; allowed: a number in [0, 1e18]");
  EXPECT_EQ(refused(own_distance({0, 1}, NAN)),
            "constraint 'rod': C: found nan in constraint 0; allowed: finite numbers");
  UserConstraint empty = own_distance({0, 1}, 1);
  empty.evaluate = {};
  EXPECT_EQ(refused(empty), "constraint 'rod': function: found none; allowed: one that gives C and its gradient");
}

TEST(UserConstraint, IsCheckedAgainstFiniteDifferences) {
  const std::vector<Vec3> x{{0, 0, 0}, {1, 2, 2}, {3, 1, 0}};
  UserConstraint own = own_distance({0, 1, 1, 2}, 1);
  check_gradients(own, x);
  own.evaluate = [inner = own.evaluate](const UserBatch& batch) {
    inner(batch);
    for (int c = 0; c < batch.count; ++c)
      if (batch.index[c] == 1) batch.gradient[2 * c + 1][2] *= 1.01;
  };
  EXPECT_TRUE(has(refusal([&] { check_gradients(own, x); }), "gradient of constraint 1 by z of its particle 1: found"));
  check_gradients(own, x, 0.1);
}

/// As TautSheets asks of the built-in ones: a direction that stays within a substep does not answer to the tension
/// across it, and such a net would shake for ever, at 0.1 to 60 m/s.
TEST(UserConstraint, GivesNothingToANetThatItsPinsStretch) {
  constexpr int kCells = 10;
  BodySpec net;
  net.name = "net", net.mass = 0.2, net.shape = GridShape{{1, 1}, {kCells, kCells}};
  std::vector<int> rim, pairs;
  for (int z = 0; z <= kCells; ++z)
    for (int x = 0; x <= kCells; ++x) {
      const int i = z * (kCells + 1) + x;
      if (x % kCells == 0 || z % kCells == 0) rim.push_back(i);
      if (x < kCells) pairs.insert(pairs.end(), {i, i + 1});
      if (z < kCells) pairs.insert(pairs.end(), {i, i + kCells + 1});
    }
  net.pins = {ListPin{rim}};
  for (const auto& [part, substeps, iterations] :
       {std::tuple{0.9, 10, 1}, std::tuple{0.8, 40, 1}, std::tuple{0.8, 10, 3}}) {
    Scene scene = scene_of({net}, kEarth, 1.0 / 60, substeps, Precision::Double);
    scene.solver.iterations = iterations;
    SimulationOptions options{.threads = 1};
    options.constraints = {own_distance(pairs, part / kCells)};
    EXPECT_LT(after(scene, 3, options).measure().speed_max, 1e-3) << part << " " << substeps << " " << iterations;
  }
}

INSTANTIATE_TEST_SUITE_P(UserConstraint, SameBits,
                         testing::Values(SameBitsScene{"OfAChain",
                                                       [](const auto&) { return swinging_chain(3, true, {}, 2); },
                                                       40,
                                                       {20},
                                                       [](const Simulation&) {},
                                                       {own_distance({0, 1, 1, 2, 2, 3}, 0.5, 1e-5)}}),
                         name_of_scene);

}  // namespace
}  // namespace malha
