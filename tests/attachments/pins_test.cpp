// SPDX-License-Identifier: Apache-2.0
#include "host/model/pins.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "host/mesh/generate.h"
#include "tests/refusal.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// The particles that these pins select on a body of this shape.
std::vector<int> held(const Shape& shape, std::vector<Pin> pins) {
  Scene scene = scene_of({body("first", GridShape{}), body("second", shape)});
  scene.bodies[1].pins = std::move(pins);
  const std::vector<bool> pinned = find_boundary_conditions(scene, 1, make_mesh(shape)).pinned;
  std::vector<int> found;
  for (std::size_t i = 0; i < pinned.size(); ++i)
    if (pinned[i]) found.push_back(static_cast<int>(i));
  return found;
}

std::string pins_refusal(const Shape& shape, const std::vector<Pin>& pins) {
  return refusal([&] { held(shape, pins); });
}

using List = std::vector<int>;
const GridShape kPinnedGrid{{2, 3}, {2, 3}};  // 3 x 4 particles a metre apart, x fastest
const ChainShape kChain{{0, 0, 0}, {4, 0, 0}, 4};

TEST(Pins, HoldNothingWhereThereAreNone) { EXPECT_EQ(held(kPinnedGrid, {}), List{}); }

TEST(Pins, OfARowHoldTheFirstOrLastRowOfAGrid) {
  EXPECT_EQ(held(kPinnedGrid, {RowPin{false}}), (List{0, 1, 2}));
  EXPECT_EQ(held(kPinnedGrid, {RowPin{true}}), (List{9, 10, 11}));
}

TEST(Pins, OfARowHoldTheFirstOrLastPointOfAChain) {
  EXPECT_EQ(held(kChain, {RowPin{false}}), List{0});
  EXPECT_EQ(held(kChain, {RowPin{true}}), List{4});
}

TEST(Pins, OfABoxHoldWhatLiesInItAndOnItsSides) {
  EXPECT_EQ(held(kPinnedGrid, {BoxPin{{0.5, -1, 1}, {2, 1, 2}}}), (List{4, 5, 7, 8}));
}

TEST(Pins, OfASphereHoldWhatLiesInItAndOnItsSurface) {
  EXPECT_EQ(held(kPinnedGrid, {SpherePin{{1, 0, 1}, 1}}), (List{1, 3, 4, 5, 7}));
}

TEST(Pins, NearestToAPointHoldOneParticleTheFirstOfEquallyNear) {
  EXPECT_EQ(held(kPinnedGrid, {NearestPin{{1.2, 5, 2.9}}}), List{10});
  EXPECT_EQ(held(kPinnedGrid, {NearestPin{{0.5, 0, 0}}}), List{0});
}

TEST(Pins, OfAListHoldItsParticles) { EXPECT_EQ(held(kPinnedGrid, {ListPin{{7, 2, 7}}}), (List{2, 7})); }

TEST(Pins, AddUp) {
  EXPECT_EQ(held(kPinnedGrid, {NearestPin{{0, 0, 0}}, NearestPin{{2, 0, 0}}, ListPin{{11}}}), (List{0, 2, 11}));
}

TEST(Pins, ThatFindNoParticleAreRefused) {
  EXPECT_EQ(pins_refusal(kPinnedGrid, {ListPin{{1}}, BoxPin{{5, 5, 5}, {6, 6, 6}}}),
            "test.json: /bodies/1/pins/1: found no particle there; allowed: a pin that holds a particle (rows are for "
            "grids and chains, rims for meshes that are not closed)");
  EXPECT_NE(pins_refusal(kPinnedGrid, {SpherePin{{1, 1, 1}, 0.9}}), "");
  EXPECT_NE(pins_refusal(kPinnedGrid, {BoxPin{{2, 1, 3}, {0, -1, 0}}}), "") << "a box inside out";
  EXPECT_NE(pins_refusal(kPinnedGrid, {ListPin{}}), "");
}

TEST(Pins, OfARowAreRefusedOnShapesWithoutRows) {
  EXPECT_EQ(pins_refusal(SphereShape{0.5, 1}, {RowPin{}}),
            "test.json: /bodies/1/pins/0: found no particle there; allowed: a pin that holds a particle (rows are for "
            "grids and chains, rims for meshes that are not closed)");
  EXPECT_NE(pins_refusal(BoxShape{}, {RowPin{}}), "");
  EXPECT_NE(pins_refusal(LatticeShape{}, {RowPin{}}), "");
}

TEST(Pins, OfParticlesThatAreNotThereAreRefused) {
  EXPECT_EQ(pins_refusal(kPinnedGrid, {ListPin{{0, 12}}}),
            "test.json: /bodies/1/pins/0: found particle 12; allowed: 0 to 11");
  EXPECT_EQ(pins_refusal(kPinnedGrid, {ListPin{{-1}}}),
            "test.json: /bodies/1/pins/0: found particle -1; allowed: 0 to 11");
}

/// A pinned body that others are attached to, or that keyframes move, stays where its pins put it, whatever pulls at
/// it.
TEST(Pins, MayHoldAWholeBody) {
  for (const char* method : {"pbd", "desbrun"})
    for (const bool alone : {true, false}) {
      BodySpec wall =
          body("wall", GridShape{{1, 1}, {4, 4}}, {stiff("distance", {"edges", "shear"}), stiff("bending")});
      if (method == std::string("pbd")) wall.constraints.push_back(stiff("long_range"));
      wall.pins = {BoxPin{{-9, -9, -9}, {9, 9, 9}}};
      std::vector<BodySpec> all{wall};
      if (!alone) all.push_back(body("falls", GridShape{{1, 1}, {4, 4}}, {stiff("distance", {"edges"})}));
      Scene scene = scene_of(all, kEarth, 0.01, 4);
      scene.solver.type = method;
      Simulation simulation(scene, {.threads = 1});
      const std::vector<Vec3> before = simulation.positions();
      for (int step = 0; step < 10; ++step) simulation.step();
      const std::vector<Vec3> after = simulation.positions();
      for (int i = 0; i < 25; ++i) EXPECT_EQ(after[i], before[i]) << method;
      if (!alone) {
        EXPECT_LT(after[30][1], before[30][1] - 0.04) << method;
      }
      simulation.measure();
    }
}

TEST(Pins, MayHoldAWholeBodyForAWhile) {
  for (const char* method : {"pbd", "desbrun"}) {
    BodySpec ball = body("ball", SphereShape{0.5, 2}, {stiff("distance", {"edges"}), compliant("pressure", 1e-6)});
    Scene scene = scene_of({ball}, kEarth, 0.01, 4);
    scene.solver.type = method;
    Simulation simulation(scene, {.threads = 1});
    simulation.step();
    const std::vector<Vec3> before = simulation.positions();
    std::vector<int> all;
    for (const Vec3& x : before) all.push_back(static_cast<int>(&x - before.data()));
    simulation.set_pins(all);
    for (int step = 0; step < 10; ++step) simulation.step();
    EXPECT_EQ(simulation.positions(), before) << method;
    simulation.set_pins({});
    for (int step = 0; step < 10; ++step) simulation.step();
    EXPECT_LT(simulation.positions()[0][1], before[0][1] - 0.04) << method;
  }
}

}  // namespace
}  // namespace malha
