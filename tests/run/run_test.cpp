// SPDX-License-Identifier: Apache-2.0
// The files that a run writes to its folder, when it writes them, and how it ends.
#include "host/run/run.h"

#include <algorithm>
#include <cstring>

#include "host/output/results.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

Json frames(int every, const std::vector<std::string>& formats) { return {{"every", every}, {"formats", formats}}; }

Json report_in(const std::filesystem::path& folder) { return Json::parse(bytes_of(folder / "report.json")); }

TEST(Run, WritesAFrameOfTheStartAndOfEveryNthStepInEveryFormat) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(false);
  scene["outputs"]["frames"] = frames(3, {"vtp", "pc2", "ply", "obj"});
  run_quietly(scene, {.out = (folder / "out").string(), .steps = 20});
  std::vector<std::string> expected{"checkpoint.malha", "frames/frames.pvd", "frames/points_sheet.pc2",
                                    "frames/rest.obj", "report.json"};
  for (int frame = 0; frame <= 6; ++frame)  // steps 0, 3, .. 18
    for (const char* extension : {".vtp", ".ply", ".obj"})
      expected.push_back("frames/frame_00000" + std::to_string(frame) + extension);
  std::sort(expected.begin(), expected.end());
  auto files = files_in(folder / "out");
  std::vector<std::string> found;
  for (const auto& [name, bytes] : files) found.push_back(name);
  EXPECT_EQ(found, expected);
  std::int32_t samples = 0;
  std::memcpy(&samples, files["frames/points_sheet.pc2"].data() + 28, sizeof samples);  // the header's last number
  EXPECT_EQ(samples, 7);
  for (const char* time : {"\"0\"", "\"0.06\"", "\"0.12\"", "\"0.18\"", "\"0.24\"", "\"0.3\"", "\"0.36\""})
    EXPECT_NE(files["frames/frames.pvd"].find(std::string("timestep=") + time), std::string::npos) << time;
}

TEST(Run, WritesNoFramesOrPicturesThatNobodyAskedFor) {
  const TemporaryFolder folder;
  run_quietly(swinging_sheet(true), {.out = (folder / "deep/er").string(), .steps = 2});
  std::vector<std::string> found;
  for (const auto& file : files_in(folder / "deep/er")) found.push_back(file.first);
  EXPECT_EQ(found, (std::vector<std::string>{"checkpoint.malha", "report.json"}));
}

/// Width and height from a PNG's first chunk.
std::array<int, 2> png_size(const std::string& png) {
  const auto big_endian = [&png](std::size_t at) {
    int value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = value * 256 + static_cast<unsigned char>(png[i]);
    return value;
  };
  if (png.size() < 24 || png.compare(0, 8, "\x89PNG\r\n\x1a\n") != 0) return {0, 0};
  return {big_endian(16), big_endian(20)};
}

TEST(Run, MakesAPictureOfTheEndASeriesAndAStoryboard) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(true);
  scene["outputs"]["pictures"] = {{"every", 4}, {"size", {64, 48}}};
  run_quietly(scene, {.out = (folder / "out").string(), .steps = 10});
  auto files = files_in(folder / "out");
  EXPECT_EQ(png_size(files["picture.png"]), (std::array{64, 48}));
  const auto [width, height] = png_size(files["storyboard.png"]);
  EXPECT_GE(width, 3 * 32) << "six half-size pictures in three columns";
  EXPECT_GE(height, 2 * 24);
  for (const char* name : {"pictures/picture_000000.png", "pictures/picture_000004.png", "pictures/picture_000008.png"})
    EXPECT_EQ(png_size(files[name]), (std::array{64, 48})) << name;
  EXPECT_EQ(files.size(), 7u) << "with report and checkpoint";
  EXPECT_NE(files["pictures/picture_000000.png"], files["picture.png"]) << "the sheet has moved";
}

TEST(Run, ReplacesTheResultsOfAnEarlierRunAndTouchesNothingElse) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  Json scene = swinging_sheet(false);
  scene["outputs"]["frames"] = frames(1, {"vtp", "pc2", "ply", "obj"});
  scene["outputs"]["pictures"] = {{"every", 1}, {"size", {16, 16}}};
  run_quietly(scene, {.out = out, .steps = 5});
  folder.write("out/notes.txt", "mine");
  folder.write("out/frames/frame_of_mind.obj", "mine");
  folder.write("out/frames/frame_000002.vtp.tmp", "left by a run that was killed");

  scene["outputs"] = {{"frames", frames(1, {"ply"})}};
  run_quietly(scene, {.out = out, .steps = 2});
  std::vector<std::string> found;
  for (const auto& file : files_in(out)) found.push_back(file.first);
  EXPECT_EQ(found, (std::vector<std::string>{"checkpoint.malha", "frames/frame_000000.ply", "frames/frame_000001.ply",
                                             "frames/frame_000002.ply", "frames/frame_of_mind.obj", "notes.txt",
                                             "report.json"}));
}

TEST(Run, TestsExpectationsOnlyWhereTheScenesDurationEnds) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  Json scene = swinging_sheet(false);
  scene["expect"] = {{"max_speed", 0}};
  EXPECT_TRUE(run_quietly(scene, {.out = out, .steps = 39}).failed_expectations.empty());
  EXPECT_TRUE(run_quietly(scene, {.out = out, .steps = 41}).failed_expectations.empty());
  const RunResult whole = run_quietly(scene, {.out = out});
  EXPECT_TRUE(whole.complete);
  ASSERT_EQ(whole.failed_expectations.size(), 1u);
  EXPECT_EQ(whole.failed_expectations[0].find("max_speed: found"), 0u) << whole.failed_expectations[0];
  EXPECT_EQ(report_in(out)["notes"], Json(whole.failed_expectations));
  EXPECT_EQ(report_in(out)["status"], "finished");
}

TEST(Run, StopsAfterTheStepInWhichItIsTold) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  Json scene = swinging_sheet(true);
  scene["outputs"]["pictures"] = {{"size", {16, 16}}};
  std::atomic<bool> stop{false};
  const auto stop_at_7 = [&stop](const Progress& now) { stop = now.step == 7; };
  const RunResult result = run(parsed(scene), {.threads = 1}, {.out = out}, stop_at_7, stop);
  EXPECT_TRUE(result.interrupted);
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(report_in(out)["status"], "interrupted");
  EXPECT_EQ(report_in(out)["step"], 7);
  EXPECT_TRUE(std::filesystem::exists(Results(out).checkpoint));
  EXPECT_TRUE(result.pictures_missing);
  EXPECT_FALSE(std::filesystem::exists(Results(out).picture)) << "whoever stops it does not want to wait for it";
  EXPECT_FALSE(std::filesystem::exists(Results(out).storyboard));
}

TEST(Run, ReportsItsProgressStepByStep) {
  const TemporaryFolder folder;
  std::vector<std::int64_t> steps;
  double time = 0;
  run(
      parsed(swinging_sheet(false)), {.threads = 1}, {.out = (folder / "out").string()},
      [&](const Progress& now) {
        steps.push_back(now.step);
        time = now.time;
        EXPECT_EQ(now.steps, 40);
        EXPECT_GE(now.step_ms, 0);
      },
      std::atomic<bool>{false});
  ASSERT_EQ(steps.size(), 40u);
  EXPECT_EQ(steps.front(), 1);
  EXPECT_EQ(steps.back(), 40);
  EXPECT_DOUBLE_EQ(time, 0.8);
}

/// A particle whose position leaves float's range: dt = 2^59 s at 2^59 m/s are exactly 2^118 m a step, and step 1024
/// reaches 2^128, which float does not represent. A second particle stays at rest.
Json rushing_particle(bool environment) {
  const Json here{{"lattice", {{"min", {0, 1, 0}}, {"max", {0, 1, 0}}, {"count", {1, 1, 1}}}}};
  Json scene{{"name", "rush"},
             {"solver", {{"type", "pbd"}, {"dt", 0x1p59}, {"substeps", 1}}},
             {"bodies",
              {{{"name", "calm"}, {"shape", here}, {"mass", 1}},
               {{"name", "rushing"}, {"shape", here}, {"mass", 1}, {"velocity", {0x1p59, 0, 0}}}}},
             {"duration", 0x1p59}};
  if (environment)
    scene["environment"] = {{{"name", "ball"}, {"shape", {{"sphere", {{"radius", 0.5}, {"subdivisions", 2}}}}}}};
  return scene;
}

class DivergingRun : public testing::TestWithParam<bool> {};

TEST_P(DivergingRun, NamesStepParticleAndBodyAndKeepsFramesAndTheLastCheckpoint) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  Json scene = rushing_particle(GetParam());
  scene["outputs"] = {{"frames", frames(256, {"vtp"})}, {"checkpoint_every", 500}, {"pictures", {{"size", {16, 16}}}}};
  const auto message = [&](bool resume) -> std::string {
    try {
      run_quietly(scene, {.out = out, .steps = 2000, .resume = resume});
    } catch (const Diverged& error) {
      return error.what();
    }
    return "";
  };
  const std::string said = message(false);
  EXPECT_EQ(said.find("step 1024 (t = "), 0u) << said;
  EXPECT_NE(said.find("particle 0 of body 'rushing'"), std::string::npos) << said;

  const Json report = report_in(out);
  EXPECT_EQ(report["status"], "diverged");
  EXPECT_EQ(report["notes"], Json({said}));
  EXPECT_EQ(report["step"], 1023) << "steps that were done";
  EXPECT_FALSE(report.contains("state"));
  int kept = 0;
  for (const auto& file : files_in(folder / "out/frames")) kept += file.first.ends_with(".vtp");
  EXPECT_EQ(kept, 4) << "of steps 0, 256, 512 and 768";
  EXPECT_EQ(message(true), said) << "from the checkpoint of step 1000";
}

INSTANTIATE_TEST_SUITE_P(Of, DivergingRun, testing::Bool(),
                         [](const auto& one) { return one.param ? "WithEnvironment" : "WithoutEnvironment"; });

TEST(Run, RefusesTheSceneBeforeItTouchesEarlierResults) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  Json scene = swinging_sheet(true);
  scene["outputs"]["frames"] = frames(1, {"vtp"});
  run_quietly(scene, {.out = out, .steps = 2});
  const auto before = files_in(out);
  scene["environment"][0]["shape"] = {{"grid", {{"size", {1, 1}}, {"cells", {1, 1}}}}};  // open, but a solid
  EXPECT_THROW(run_quietly(scene, {.out = out, .steps = 1}), InputError);
  EXPECT_EQ(files_in(out), before);
  EXPECT_THROW(run_quietly(scene, {.out = (folder / "other").string(), .steps = 1}), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "other"));
}

TEST(Run, SaysWhichFolderItCannotMake) {
  const TemporaryFolder folder;
  const std::string file = folder.write("file", "not a folder");
  try {
    run_quietly(swinging_sheet(false), {.out = file + "/out", .steps = 1});
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(dynamic_cast<const InputError*>(&error), nullptr);
    EXPECT_EQ(std::string(error.what()).find(file + "/out: cannot make the folder: "), 0u) << error.what();
  }
  EXPECT_EQ(bytes_of(file), "not a folder");
}

}  // namespace
}  // namespace malha
