// SPDX-License-Identifier: Apache-2.0
// The glTF file of a run: when it is written, and how a resumed run continues it.
#include <gtest/gtest.h>

#include "host/output/results.h"
#include "host/run/summary.h"
#include "tests/output/glb_scene.h"
#include "tests/output/gltf_file.h"
#include "tests/refusal.h"

namespace malha {
namespace {

namespace fs = std::filesystem;

TEST(GlbOfARun, AppearsWhenTheRunEndsAndIsRemovedWithTheNextRun) {
  const TemporaryFolder folder;
  Json scene = glb_scene(folder);
  std::atomic<bool> stop{false};
  const auto watch = [&](const Progress& now) {
    EXPECT_FALSE(fs::exists(folder / "out/frames/run.glb"));
    EXPECT_TRUE(fs::exists(folder / "out/frames/run.glb.part"));
    stop = now.step == 3;
  };
  EXPECT_TRUE(run(parsed(scene), {.threads = 1}, {.out = (folder / "out").string()}, watch, stop).interrupted);
  EXPECT_EQ(GltfFile(folder / "out/frames/run.glb").mesh("rope").primitives[0].targets.size(), 4u);
  EXPECT_FALSE(fs::exists(folder / "out/frames/run.glb.part"));
  EXPECT_TRUE(has(list_results(Results(folder / "out")), "run.glb (browsers, Blender)\n"));
  folder.write("out/frames/run.glb.part", "of a run that was killed");
  scene["outputs"].erase("frames");
  run_with_frames(folder, scene, "out");
  EXPECT_FALSE(fs::exists(folder / "out/frames"));
}

// 2^118 m a step: beyond the largest float of 2^128 at the 1024th.
TEST(GlbOfARun, EndsBeforeItDiverges) {
  const TemporaryFolder folder;
  const Json here{{"lattice", {{"min", {0, 1, 0}}, {"max", {0, 1, 0}}, {"count", {1, 1, 1}}}}};
  const Json scene{{"name", "rush"},
                   {"solver", {{"type", "pbd"}, {"dt", 0x1p59}, {"substeps", 1}}},
                   {"bodies", {{{"name", "rushing"}, {"shape", here}, {"mass", 1}, {"velocity", {0x1p59, 0, 0}}}}},
                   {"outputs", {{"frames", {{"every", 1}, {"formats", {"glb"}}}}}},
                   {"duration", 0x1p59}};
  EXPECT_THROW(run_with_frames(folder, scene, "out", 1999), Diverged);
  EXPECT_EQ(GltfFile(folder / "out/frames/run.glb").mesh("rushing").primitives[0].targets.size(), 1024u);
}

TEST(GlbOfARun, ThatCannotBeWrittenLeavesTheFramesForTheNextPart) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(true);
  scene["outputs"]["frames"] = {{"every", 4}, {"formats", {"glb"}}};
  const std::string whole = bytes_of(run_with_frames(folder, scene, "whole") / "run.glb");
  const std::string out = (folder / "parts").string();
  const auto fill_disk = [&](const Progress& now) {
    if (now.step == 20) fs::create_symlink("/dev/full", folder / "parts/frames/run.glb.tmp");
  };
  EXPECT_THROW(run(parsed(scene), {.threads = 1}, {.out = out, .steps = 20}, fill_disk, std::atomic<bool>{false}),
               std::runtime_error);
  EXPECT_FALSE(fs::exists(folder / "parts/frames/run.glb"));
  run_quietly(scene, {.out = out, .resume = true});
  EXPECT_TRUE(bytes_of(folder / "parts/frames/run.glb") == whole);
}

TEST(GlbOfARun, ThatDoesNotContinueIsRefusedAndKept) {
  const TemporaryFolder folder;
  const auto continue_at = [&](int next) {
    try {
      FrameWriter(folder / "", {"glb"}, of_all_kinds(), next);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  FrameWriter writer(folder / "", {"glb"}, of_all_kinds());
  writer.write(0, of_all_kinds().rest, std::vector<Vec3>(9)), writer.finish();
  const std::string glb = bytes_of(folder / "run.glb");
  EXPECT_EQ(continue_at(5), (folder / "run.glb").string() + ": does not continue at frame 5 of 9 points");
  for (const std::size_t cut : {std::size_t{0}, std::size_t{15}, std::size_t{700}, glb.size() - 1500}) {
    folder.write("run.glb", glb.substr(0, cut));
    EXPECT_NE(continue_at(1), "") << cut;
    EXPECT_EQ(bytes_of(folder / "run.glb"), glb.substr(0, cut));
    EXPECT_FALSE(fs::exists(folder / "run.glb.part"));
  }
  folder.write("run.glb", glb);
  EXPECT_EQ(continue_at(1), "");
}

}  // namespace
}  // namespace malha
