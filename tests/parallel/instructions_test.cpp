// SPDX-License-Identifier: Apache-2.0
// Packs of any width, compiled for any instruction set, give the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "host/solver/solver.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// Every kind of constraint, stiff and compliant. With 23 x 19 particles, batches end in partial packs of 4, 8 and 16
/// lanes.
Scene cloth(Precision precision) {
  BodySpec body;
  body.name = "cloth";
  body.shape = GridShape{{1.6, 1.2}, {22, 18}};
  body.mass = 0.5;
  body.pins = {NearestPin{{0, 0, 0}}};
  body.constraints = {stiff("distance", {"edges"}, 0.9),
                      compliant("distance", 1e-6, {"shear"}),
                      stiff("distance_limit", {"edges"}, 1, 0.02),
                      compliant("distance_limit", 1e-6, {"shear"}, 0.02),
                      stiff("bending", {}, 0.1),
                      compliant("bending", 1e-3)};
  return scene_of({body}, kEarth, 1.0 / 60, 5, precision);
}

class InstructionSet : public testing::TestWithParam<Precision> {};

TEST_P(InstructionSet, DoesNotChangeABit) {
  const std::vector<std::string> sets = instruction_sets();
  if (sets.size() == 1) GTEST_SKIP() << "one set alone: " << sets[0];
  std::map<std::string, std::uint64_t> hashes;
  for (const std::string& set : sets)
    for (const int threads : {1, 2}) {
      const Simulation cloth_now = after(cloth(GetParam()), 0.5, {.threads = threads, .instructions = set});
      EXPECT_EQ(cloth_now.solver().facts().instructions, set);
      EXPECT_EQ(cloth_now.state_hash(), hashes.try_emplace(sets[0], cloth_now.state_hash()).first->second) << set;
    }
}

INSTANTIATE_TEST_SUITE_P(, InstructionSet, testing::Values(Precision::Float, Precision::Double),
                         [](const auto& test) { return test.param == Precision::Float ? "Float" : "Double"; });

/// A stored number, because builds cannot meet in one test: native and portable ones, optimised or with sanitizers, all
/// give this one. It changes with the arithmetic of a kernel, and with nothing else.
TEST(EveryBuild, GivesTheSameBits) {
  for (const auto& [precision, bending, hash] :
       {std::tuple(Precision::Float, BendingMethod::Projected, 0x778c8f6fb692e65eull),
        std::tuple(Precision::Double, BendingMethod::Projected, 0xaf873dbcb86877f6ull),
        std::tuple(Precision::Float, BendingMethod::Filtered, 0x4f9b4586103c34dull),
        std::tuple(Precision::Double, BendingMethod::Filtered, 0xbcc4fc31f7024a4dull)}) {
    Scene scene = cloth(precision);
    scene.solver.bending = bending;
    EXPECT_EQ(after(scene, 0.5).state_hash(), hash);
  }
  Scene filtered = cloth(Precision::Float);
  filtered.solver.type = "desbrun";
  for (const auto& [filter, hash] :
       {std::pair(FilterKind::Dense, 0xf63f12323ffabd57ull), std::pair(FilterKind::Sparse, 0x343006b8a265b50full)}) {
    filtered.solver.desbrun.filter = filter;
    EXPECT_EQ(after(filtered, 0.5).state_hash(), hash);
  }
}

TEST(InstructionSets, AreChosenFromTheWidest) {
  EXPECT_EQ(Simulation(cloth(Precision::Float), {.threads = 1}).solver().facts().instructions,
            instruction_sets().back());
}

TEST(InstructionSets, RefuseOthers) {
  EXPECT_THROW(Simulation(cloth(Precision::Float), {.threads = 1, .instructions = "mmx"}), InputError);
}

}  // namespace
}  // namespace malha
