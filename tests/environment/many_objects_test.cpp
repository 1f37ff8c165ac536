// SPDX-License-Identifier: Apache-2.0
// The memory of scenes with many environment objects grows with the contacts close to them, not with the pairs of
// particles and objects.
#include <gtest/gtest.h>

#include "host/environment/proximity_memory.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// A sheet at that height (m) over many small boxes, of which it will lie on few.
Scene over_boxes(int objects, double height = 0) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {40, 40}}, sheet.mass = 1;
  sheet.constraints = {stiff("distance", {"edges"})};
  sheet.transform.translate = {0, height, 0};
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 4, Precision::Float);
  for (int k = 0; k < objects; ++k) {
    EnvironmentSpec box;
    box.name = "box " + std::to_string(k), box.shape = BoxShape{{0.05, 0.05, 0.05}, {{1, 1, 1}}};
    box.transform.translate = {0.5 + (k < 2 ? 0.2 * k : 3.0 * k), -0.05, 0.5};  // two of them below the sheet
    scene.environment.push_back(box);
  }
  return scene;
}

TEST(ManyObjects, AStateHoldsOnlyWhatIsNear) {
  const auto bytes = [](int objects) {
    Simulation simulation(over_boxes(objects), {.threads = 1});
    for (int step = 0; step < 20; ++step) simulation.step();
    EXPECT_GT(simulation.measure().contacts, 0);
    return simulation.save_state().size();
  };
  // For the 58 boxes far away: a bounding box for each group of 64 of the 41 x 41 particles, where each pair took 64
  // bytes.
  EXPECT_EQ(bytes(60) - bytes(2), 58 * groups_of(41 * 41) * sizeof(GroupBox));
}

/// A bounding box for each group of 64 particles, and its position: 32 bytes an object and group, where each pair took
/// 20 bytes.
TEST(ManyObjects, TakeMemoryForWhatIsNearAlone) {
  const auto bytes = [](int objects) {
    Simulation simulation(over_boxes(objects), {.threads = 1});
    for (int step = 0; step < 20; ++step) simulation.step();
    return simulation.solver().facts().contact->far_bytes;
  };
  const std::size_t two = bytes(2), all = bytes(60), handed = 16;  // bytes of an object's own numbers
  EXPECT_LE(all - two, 58 * (groups_of(41 * 41) * (sizeof(GroupBox) + sizeof(int)) + handed));
  EXPECT_LT(all - two, 58 * 41 * 41) << "not a byte a pair";
}

TEST(ManyObjects, AStateIsRestoredToTheLastBitOfWhatIsKnownOfContacts) {
  for (const double height : {0.0, 0.3})
    for (const int threads : {1, 2}) {
      Simulation simulation(over_boxes(20, height), {.threads = 1});
      Simulation other(over_boxes(20, height), {.threads = threads});
      for (int step = 0; step < 8; ++step) simulation.step();
      const std::string state = simulation.save_state();
      other.restore_state(state);
      EXPECT_EQ(other.save_state(), state);
    }
}

void expect_contacts_with_boxes(const Simulation& simulation) { EXPECT_GT(simulation.measure().contacts, 0); }

INSTANTIATE_TEST_SUITE_P(
    ManyObjects, SameBits,
    testing::Values(
        SameBitsScene{"Lain", [](const auto&) { return over_boxes(20); }, 20, {8}, expect_contacts_with_boxes},
        SameBitsScene{"Fallen", [](const auto&) { return over_boxes(20, 0.3); }, 20, {8}, expect_contacts_with_boxes}),
    name_of_scene);

}  // namespace
}  // namespace malha
