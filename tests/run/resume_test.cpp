// SPDX-License-Identifier: Apache-2.0
// A resumed run equals the uninterrupted one, bit by bit; any other checkpoint is refused.
#include "host/base/build_info.h"
#include "host/run/run.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

struct ResumedKind {
  std::string name, precision;
  bool environment;
};
void PrintTo(const ResumedKind& kind, std::ostream* out) { *out << kind.name; }

class Resume : public testing::TestWithParam<ResumedKind> {
 protected:
  Resume() : scene_(swinging_sheet(GetParam().environment, GetParam().precision)) {
    scene_["outputs"]["frames"] = {{"every", 3}, {"formats", {"vtp", "pc2", "ply", "obj", "usda"}}};
    if (has_gltf()) scene_["outputs"]["frames"]["formats"].push_back("glb");
    scene_["outputs"]["pictures"] = {{"size", {16, 16}}};
    run_quietly(scene_, {.out = (folder_ / "whole").string()});
  }

  /// Compares every frame, the picture of the end, and the checkpoint, which contains every bit that a later step
  /// depends on.
  void expect_same_as_whole(const std::string& out) {
    auto whole = files_in(folder_ / "whole"), parts = files_in(folder_ / out);
    EXPECT_EQ(Json::parse(parts["report.json"])["state_hash"], Json::parse(whole["report.json"])["state_hash"]);
    for (auto* files : {&whole, &parts}) files->erase("report.json"), files->erase("storyboard.png");
    EXPECT_EQ(whole.size(), 3u * 14 + 7 + has_gltf())
        << "frames of steps 0 to 39, and frames.pvd, points_sheet.pc2, rest.obj, run.usda and its part, run.glb";
    ASSERT_EQ(parts.size(), whole.size());
    for (const auto& [name, bytes] : whole) EXPECT_TRUE(parts[name] == bytes) << name << " differs";
  }

  TemporaryFolder folder_;
  Json scene_;
};

TEST_P(Resume, EqualsTheUninterruptedRun) {
  const std::string out = (folder_ / "parts").string();
  run_quietly(scene_, {.out = out, .steps = 11});
  run_quietly(scene_, {.out = out, .steps = 30, .resume = true});
  run_quietly(scene_, {.out = out, .resume = true});
  expect_same_as_whole("parts");
}

TEST_P(Resume, EqualsTheUninterruptedRunOnOtherThreadsAndBackends) {
  const std::string out = (folder_ / "parts").string();
  const auto part = [&](const SimulationOptions& options, std::int64_t steps, bool resume) {
    run(
        parsed(scene_), options, {.out = out, .steps = steps, .resume = resume}, [](const Progress&) {},
        std::atomic<bool>{false});
  };
  part({.backend = Backend::Serial}, 13, false);
  part({.threads = 3}, 26, true);
  part({.threads = 2}, 40, true);
  expect_same_as_whole("parts");
}

TEST_P(Resume, EqualsTheUninterruptedRunAfterAStopAtAnyStep) {
  for (const int when : {0, 1, 39}) {
    const std::string name = "stopped_" + std::to_string(when), out = (folder_ / name).string();
    std::atomic<bool> stop{when == 0};
    const auto watch = [&](const Progress& now) { stop = now.step == when; };
    EXPECT_TRUE(run(parsed(scene_), {.threads = 1}, {.out = out}, watch, stop).interrupted);
    EXPECT_TRUE(run_quietly(scene_, {.out = out, .resume = true}).complete);
    expect_same_as_whole(name);
  }
}

/// A run that was killed between two checkpoints leaves frames that the resumed one writes again.
TEST_P(Resume, EqualsTheUninterruptedRunAfterAKill) {
  const std::string out = (folder_ / "parts").string();
  scene_["outputs"]["checkpoint_every"] = 10;
  struct Killed {};
  const auto kill_at_28 = [](const Progress& now) {
    if (now.step == 28) throw Killed{};
  };
  EXPECT_THROW(run(parsed(scene_), {.threads = 1}, {.out = out}, kill_at_28, std::atomic<bool>{false}), Killed);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "parts/frames/frame_000009.vtp")) << "step 27";
  run_quietly(scene_, {.out = out, .steps = 22, .resume = true});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "parts/frames/frame_000009.vtp"));
  run_quietly(scene_, {.out = out, .resume = true});
  expect_same_as_whole("parts");
}

INSTANTIATE_TEST_SUITE_P(Of, Resume,
                         testing::Values(ResumedKind{"Float", "float", false}, ResumedKind{"Double", "double", false},
                                         ResumedKind{"FloatWithEnvironment", "float", true},
                                         ResumedKind{"DoubleWithEnvironment", "double", true}),
                         [](const auto& one) { return one.param.name; });

TEST(ResumeWith, AnotherNumberOfStepsBetweenFramesKeepsThoseThatAreThere) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  Json scene = swinging_sheet(false);
  scene["outputs"]["frames"] = {{"every", 2}, {"formats", {"vtp"}}};
  run_quietly(scene, {.out = out, .steps = 9});  // frames 0 .. 4
  const auto before = files_in(folder / "out/frames");
  scene["outputs"]["frames"]["every"] = 10;
  run_quietly(scene, {.out = out, .resume = true});  // of steps 10, 20, 30, 40
  auto after = files_in(folder / "out/frames");
  EXPECT_EQ(after.size(), before.size() + 4);
  for (const auto& [name, bytes] : before) {
    EXPECT_EQ(after[name] == bytes, name != "frames.pvd") << name;
  }
  for (const char* line :
       {"\"0.16\" file=\"frame_000004.vtp\"", "\"0.2\" file=\"frame_000005.vtp\"", "\"0.8\" file=\"frame_000008.vtp\""})
    EXPECT_NE(after["frames.pvd"].find(line), std::string::npos) << line;
}

/// The refusal of a resume, after which the folder must be as it was.
class ResumeRefuses : public testing::Test {
 protected:
  ResumeRefuses() { run_quietly(scene_, {.out = out_, .steps = 20}); }

  std::string refusal(const Json& scene, const RunOptions& options) {
    const auto before = files_in(out_);
    const std::string said = malha::refusal([&] { run_quietly(scene, options); });
    EXPECT_TRUE(files_in(out_) == before);
    return said;
  }

  TemporaryFolder folder_;
  std::string out_ = (folder_ / "out").string(), checkpoint_ = out_ + "/checkpoint.malha";
  Json scene_ = swinging_sheet(true);
};

TEST_F(ResumeRefuses, AFolderWithoutCheckpoint) {
  const std::string other = (folder_ / "other").string();
  EXPECT_EQ(refusal(scene_, {.out = other, .resume = true}),
            other +
                "/checkpoint.malha: cannot read: No such file or directory; allowed: a checkpoint that an earlier run "
                "left there");
  EXPECT_FALSE(std::filesystem::exists(other));
}

TEST_F(ResumeRefuses, AnEndThatIsReachedAlready) {
  EXPECT_EQ(refusal(scene_, {.out = out_, .steps = 20, .resume = true}),
            checkpoint_ + ": found the state of step 20; allowed: one from before the end of this run, step 20");
}

TEST_F(ResumeRefuses, ACheckpointOfAnotherScene) {
  const std::string another = checkpoint_ +
                              ": found a checkpoint of another scene; allowed: one of this scene with the same bodies, "
                              "pins, solver, environment, and gravity and wind at the start";
  const auto changed = [this](const char* pointer, const Json& value) {
    Json scene = scene_;
    scene[Json::json_pointer(pointer)] = value;
    return refusal(scene, {.out = out_, .resume = true});
  };
  EXPECT_EQ(changed("/solver/precision", "double"), another);
  EXPECT_EQ(changed("/solver/substeps", 4), another);
  EXPECT_EQ(changed("/gravity/1", -9.8), another);
  EXPECT_EQ(changed("/bodies/0/shape/grid/cells/0", 7), another);
  EXPECT_EQ(changed("/bodies/0/constraints/1/stiffness", 0.3), another);
  EXPECT_EQ(changed("/environment/0/friction", 0.4), another);
}

TEST_F(ResumeRefuses, ACheckpointOfAnotherMeshInAFileOfTheSameName) {
  const std::string mesh = folder_.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3\nf 1 3 4\n");
  scene_["bodies"][0]["shape"] = {{"mesh", mesh}};
  scene_["bodies"][0]["constraints"][0]["elements"] = {"edges"};
  run_quietly(scene_, {.out = out_, .steps = 20});
  folder_.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 4\nf 2 3 4\n");  // the other diagonal
  EXPECT_NE(refusal(scene_, {.out = out_, .resume = true}).find("another scene"), std::string::npos);
}

TEST_F(ResumeRefuses, ADamagedCheckpoint) {
  const std::string whole = bytes_of(checkpoint_);
  std::string flipped = whole;
  flipped.back() = static_cast<char>(flipped.back() ^ 1);
  for (const std::string& damaged : {flipped, whole.substr(0, whole.size() - 1), whole + "x"}) {
    folder_.write("out/checkpoint.malha", damaged);
    EXPECT_NE(refusal(scene_, {.out = out_, .resume = true}).find("found a damaged checkpoint"), std::string::npos);
  }
  for (const std::string& foreign : {std::string(), std::string("a diary"), whole.substr(0, 30)}) {
    folder_.write("out/checkpoint.malha", foreign);
    EXPECT_NE(refusal(scene_, {.out = out_, .resume = true}).find("found no checkpoint; "), std::string::npos);
  }
}

TEST_F(ResumeRefuses, NothingWhereOnlyDurationOutputsNameAndExpectationsDiffer) {
  scene_["name"] = "renamed";
  scene_["duration"] = 0.5;
  scene_["outputs"]["checkpoint_every"] = 3;
  scene_["expect"]["max_speed"] = 100;
  const RunResult result = run_quietly(scene_, {.out = out_, .resume = true});
  EXPECT_TRUE(result.complete);
  EXPECT_TRUE(result.failed_expectations.empty());
}

}  // namespace
}  // namespace malha
