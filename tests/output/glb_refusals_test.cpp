// SPDX-License-Identifier: Apache-2.0
// Runs that glTF cannot represent are refused before anything is written.
#include <gtest/gtest.h>

#include "host/base/build_info.h"
#include "host/output/frames.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

Json scene_with_glb(int every) {
  Json scene = swinging_sheet(false);
  scene["outputs"]["frames"] = {{"every", every}, {"formats", {"glb"}}};
  return scene;
}

TEST(GlbRefuses, EverythingWhereMalhaWasBuiltWithoutTinygltf) {
  if (has_gltf()) GTEST_SKIP() << "built with tinygltf";
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  EXPECT_EQ(refusal([&] { run_quietly(scene_with_glb(1), {.out = out}); }),
            "test.json: /outputs/frames/formats: found glb, and this malha was built without tinygltf (Debian: "
            "libtinygltf-dev); allowed: vtp, pc2, ply, obj, usda");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(GlbRefuses, MoreFramesThanBrowsersTake) {
  if (!has_gltf()) GTEST_SKIP() << "built without tinygltf";
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  EXPECT_EQ(refusal([&] { run_quietly(scene_with_glb(3), {.out = out, .steps = 6000}); }),
            "test.json: /outputs/frames/every: found 3, with which glb has 2001 frames; allowed: what leads to at most "
            "2000 in one file");
  EXPECT_FALSE(std::filesystem::exists(out));
  run_quietly(scene_with_glb(3), {.out = out, .steps = 5});  // frames 0 and 1
  const auto before = files_in(out);
  EXPECT_NE(refusal([&] { run_quietly(scene_with_glb(3), {.out = out, .steps = 6000, .resume = true}); }), "");
  EXPECT_TRUE(files_in(out) == before);
  EXPECT_TRUE(run_quietly(scene_with_glb(0), {.out = out, .steps = 41}).interrupted == false) << "without frames";
}

TEST(GlbRefuses, MoreBytesThanItsHeaderCounts) {
  Scene scene = parsed(swinging_sheet(false));
  scene.outputs.every = 2;
  EXPECT_EQ(refusal([&] { check_glb(scene, 333'333, 1000); }), "");
  EXPECT_EQ(refusal([&] { check_glb(scene, 333'333, 2000); }),
            "test.json: /outputs/frames/every: found 2, with which glb has 7.45 GiB of frames; allowed: what leads to "
            "at most 3.73 GiB in one file");
}

}  // namespace
}  // namespace malha
