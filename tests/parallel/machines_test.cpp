// SPDX-License-Identifier: Apache-2.0
// Machines that patches are cut for: patches fit the machine, and the bits depend on it alone.
#include <gtest/gtest.h>

#include <string>

#include "host/model/machine.h"
#include "host/patch/patch_plan.h"
#include "host/report/device_estimate.h"
#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"
#if defined(TESTS_BLOCKS)
#include "tests/parallel/blocks_solvers.h"
#endif

namespace malha {
namespace {

/// A grid, a body of irregular tetrahedra, and one with wind.
std::vector<Scene> scenes_to_cut() {
  std::vector<Scene> all{load_shipped("sheet_shear"), load_shipped("soft_bunny"), load_shipped("flag")};
  std::get<GridShape>(all.front().bodies.front().shape).cells = {120, 90};
  return all;
}

TEST(Machines, CutPatchesThatFitTheirFastMemory) {
  for (Scene scene : scenes_to_cut())
    for (const Precision precision : {Precision::Float, Precision::Double})
      for (const Machine& machine : machines()) {
        scene.solver.precision = precision;
        const Model model = build_model(scene, 1, machine.patch_bounds(precision));
        const std::size_t wanted = make_solver(model, 1)->facts().patches.memory_bytes;
        if (machine.fast_bytes > 0) {
          // With the kibibyte that each block takes besides, there are as many as registers allow.
          const std::size_t blocks = machine.groups(precision) / machine.multiprocessors;
          EXPECT_LE(blocks * (wanted + 1024), machine.fast_bytes + 1024) << scene.name << " for " << machine.name;
        }
      }
}

TEST(Machines, OfDevicesHaveMorePatchesThanCoresDo) {
  const Scene scene = scenes_to_cut().front();
  const auto patches = [&](const char* machine) {
    return build_model(scene, 1, machine_named(machine).patch_bounds(scene.solver.precision)).patches.count();
  };
  EXPECT_GT(patches("h200"), patches("cpu"));
}

TEST(Machines, AreWhatTheBitsDependOnAndNotTheThreads) {
  for (const Scene& scene : scenes_to_cut()) {
    const auto hash = [&](const std::string& machine, int threads) {
      Simulation simulation(scene, {.threads = threads, .machine = machine});
      for (int step = 0; step < 5; ++step) simulation.step();
      return simulation.state_hash();
    };
    EXPECT_EQ(hash("h200", 1), hash("h200", 3)) << scene.name;
    EXPECT_EQ(hash("cpu", 1), after(scene, 5 * scene.solver.dt).state_hash()) << scene.name << ": the default";
#if defined(TESTS_BLOCKS)
    const Model model = build_model(scene, 1, machine_named("h200").patch_bounds(scene.solver.precision));
    const auto blocks = make_on_blocks(model, Blocks{32, 1});
    for (int step = 0; step < 2; ++step) blocks->step();
    const auto host = make_solver(model, 1);
    for (int step = 0; step < 2; ++step) host->step();
    EXPECT_EQ(blocks->state_hash(), host->state_hash()) << scene.name << ": on blocks of threads";
#endif
  }
}

TEST(Machines, OfDevicesReplayStepsThatAreAllAlike) {
  const auto replays = [](const Scene& scene, const char* machine) {
    const Simulation simulation(scene, {.machine = machine});
    return estimate_device(simulation, machine_named(machine)).replays;
  };
  EXPECT_TRUE(replays(load_shipped("flag"), "h200"));
  EXPECT_TRUE(replays(load_shipped("desbrun_sheet"), "h200"));
  EXPECT_FALSE(replays(load_shipped("flag"), "cpu")) << "which records nothing";
  for (const char* name : {"drape_bunny", "carried_sheet", "crumpled_ball"})
    EXPECT_FALSE(replays(load_shipped(name), "h200")) << name;
}

TEST(Machines, StayThoseOfACheckpoint) {
  const Scene scene = scenes_to_cut().front();
  const TemporaryFolder folder;
  const std::string path = (folder / "checkpoint").string();
  Simulation simulation(scene, {.threads = 1, .machine = "h200"});
  simulation.step();
  simulation.save_checkpoint(path);
  Simulation other(scene, {.threads = 1});
  EXPECT_THROW(other.load_checkpoint(path), InputError);  // the order of the particles differs
}

TEST(Machines, AreRefusedByAnotherName) {
  EXPECT_EQ(refusal([] { machine_named("h2"); }), "machine: found \"h2\"; allowed: cpu, a100, h100, h200");
}

/// A sheet in one patch: each substep reads x, its rounding error, v and w of its particles, and writes the first
/// three.
TEST(PatchTraffic, OfOnePatchIsItsStateThereAndBack) {
  Scene scene = load_shipped("sheet_shear");
  std::get<GridShape>(scene.bodies.front().shape).cells = {12, 12};
  scene.bodies.front().pins.clear();
  scene.solver.iterations = 1;
  const Simulation simulation(scene, {.threads = 1});
  ASSERT_EQ(simulation.solver().facts().patches.patches, 1);
  const double particles = 13 * 13, numbers = 10 + 9;
  const PatchPlan plan = plan_patches(simulation.model());
  EXPECT_EQ(patch_traffic(simulation.model(), simulation.solver(), plan).particle_bytes,
            numbers * sizeof(float) * particles * scene.solver.substeps);
}

/// Where patches share particles, each solve reads their positions, displacements and w, and writes displacements;
/// nothing else is read or written.
TEST(PatchTraffic, OfSeveralPatchesAddsWhatTheyShare) {
  bool turns = false;
  for (Scene scene : scenes_to_cut()) {
    for (BodySpec& body : scene.bodies) body.pins.clear();
    scene.environment.clear(), scene.expect = {};
    scene.solver.iterations = 1, scene.solver.bending = BendingMethod::Projected;  // filtered, patches do not fuse
    const Simulation simulation(scene, {.threads = 1, .machine = "h200"});
    ASSERT_TRUE(simulation.solver().step_plan().fuses());
    const PatchPlan plan = plan_patches(simulation.model());
    turns = turns || plan.colours() > 2;
    std::vector<int> visits(simulation.model().x.size(), 0);
    for (int colour = 0; colour < plan.colours(); ++colour)
      for (int k = plan.colour_begin[colour]; k < plan.colour_begin[colour + 1]; ++k)
        for (int s = plan.patches[k].segment; s < plan.patches[k].segment + plan.patches[k].segments; ++s) {
          const Segment& segment = plan.segments[s];
          for (int i = segment.global; i < segment.global + segment.count; ++i)
            // twice, except for the last colour and the one where the sweep turns
            visits[i] += colour < plan.colours() - 2 ? 2 : 1;
        }
    double numbers = 0;
    for (const int count : visits) {
      // The first solve reads the velocity in place of the displacement, and the last one writes the state; if it is
      // another one it reads the velocity before.
      if (count == 1) numbers += 10 + 9;
      if (count > 1) numbers += (10 + 3) + (count - 2) * (10 + 3) + (10 + 3 + 9);
    }
    const PatchTraffic traffic = patch_traffic(simulation.model(), simulation.solver(), plan);
    EXPECT_EQ(traffic.particle_bytes, numbers * sizeof(float) * scene.solver.substeps) << scene.name;
    std::size_t constraints = 0;
    for (const SetStats& set : simulation.solver().facts().sets) constraints += set.bytes;
    const double once = static_cast<double>(constraints) * scene.solver.substeps;
    EXPECT_GT(traffic.constraint_bytes, plan.colours() > 2 ? 1.2 * once : 0.999 * once) << scene.name;
    EXPECT_LT(traffic.constraint_bytes, plan.colours() > 2 ? 2 * once : 1.001 * once) << scene.name << ": sums rounded";
  }
  EXPECT_TRUE(turns) << "there and back";
}

}  // namespace
}  // namespace malha
