// SPDX-License-Identifier: Apache-2.0
// Memory of scenes with many environment objects is that of what is near.
#include <gtest/gtest.h>

#include "host/environment/contact_memory.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// A sheet so high (m) over so many small boxes, of which it comes to lie on few.
Scene over_boxes(int objects, double height = 0) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {40, 40}}, sheet.mass = 1;
  sheet.constraints = {stiff("distance", {"edges"})};
  sheet.transform.translate = {0, height, 0};
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 4, Precision::Float);
  for (int k = 0; k < objects; ++k) {
    EnvironmentSpec box;
    box.name = "box " + std::to_string(k), box.shape = BoxShape{{0.05, 0.05, 0.05}, {1, 1, 1}};
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
  // Of the 58 that are far: a box for each word of 64 of the 41 x 41 particles, where each pair took 64 bytes.
  EXPECT_EQ(bytes(60) - bytes(2), 58 * groups_of(41 * 41) * sizeof(GroupBox));
}

/// A box for each word of 64 particles, and where it lies: 32 bytes an object and word, where each pair took 20 bytes.
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

/// Also while nothing comes near, when steps are taken without a look at the environment.
TEST(ManyObjects, GoOnFromAStateWithTheSameBits) {
  for (const double height : {0.0, 0.3})
    for (const int threads : {1, 2}) {
      Simulation simulation(over_boxes(20, height), {.threads = 1});
      Simulation other(over_boxes(20, height), {.threads = threads});
      for (int step = 0; step < 8; ++step) simulation.step();
      const std::string state = simulation.save_state();
      for (int step = 0; step < 12; ++step) simulation.step();
      const std::string end = simulation.save_state();
      EXPECT_GT(simulation.measure().contacts, 0);
      other.restore_state(state);
      EXPECT_EQ(other.save_state(), state);
      for (int step = 0; step < 12; ++step) other.step();
      EXPECT_EQ(other.save_state(), end) << "to the last bit of what is known of contacts, on " << threads
                                         << " threads";
    }
}

}  // namespace
}  // namespace malha
