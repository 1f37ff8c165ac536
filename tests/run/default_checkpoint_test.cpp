// SPDX-License-Identifier: Apache-2.0
// Default checkpoints: those that are written without being named, when they are removed, and the lock on their folder.
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "host/base/file.h"
#include "host/output/results.h"
#include "host/run/redraw.h"
#include "host/run/run.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

struct Flush {
  bool folder;       // otherwise a file
  bool whole_there;  // whether the file already had its final name
};
std::vector<Flush>* flushes = nullptr;
std::string flushed_name;

}  // namespace
}  // namespace malha

/// Replaces the function of the library, so that a test records what is flushed, and when.
extern "C" int fsync(int descriptor) {
  if (malha::flushes != nullptr) {
    const bool folder = std::filesystem::is_directory("/proc/self/fd/" + std::to_string(descriptor));
    malha::flushes->push_back({folder, std::filesystem::exists(malha::flushed_name)});
  }
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

namespace malha {
namespace {

/// Steps until `when`, after which the run counts as killed: nothing more is written.
struct KilledRun {};
void run_and_kill(const Json& scene, const RunOptions& options, std::int64_t when) {
  const auto watch = [&](const Progress& now) {
    if (now.step == when) throw KilledRun{};
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  };
  EXPECT_THROW(run(parsed(scene), {.threads = 1}, options, watch, std::atomic<bool>{false}), KilledRun);
}

TEST(DefaultCheckpoint, IsWrittenByTheClockAndGoneOnWithByTheSameBits) {
  const TemporaryFolder folder;
  const Json scene = swinging_sheet(true);
  const std::string parts = folder / "parts", whole = folder / "whole";
  run_and_kill(scene, {.out = parts, .checkpoint_seconds = 0.01}, 35);
  ASSERT_TRUE(std::filesystem::exists(Results(parts).checkpoint)) << "35 steps took 70 ms at the least";
  std::int64_t first = 0;
  const auto watch = [&first](const Progress& now) { first = first == 0 ? now.step : first; };
  run(parsed(scene), {.threads = 1}, {.out = parts, .resume = true}, watch, std::atomic<bool>{false});
  EXPECT_GT(first, 1) << "it did not begin anew";
  run_quietly(scene, {.out = whole});
  EXPECT_EQ(bytes_of(Results(parts).checkpoint), bytes_of(Results(whole).checkpoint));
}

TEST(DefaultCheckpoint, IsLeftOutWhereTheSceneOrTheTimeSaysSo) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  Json scene = swinging_sheet(true);
  run_and_kill(scene, {.out = out}, 20);
  EXPECT_FALSE(std::filesystem::exists(Results(out).checkpoint)) << "half a minute has not gone by";
  scene["outputs"]["checkpoint_every"] = 0;
  run_and_kill(scene, {.out = out, .checkpoint_seconds = 0}, 20);
  EXPECT_FALSE(std::filesystem::exists(Results(out).checkpoint));
}

TEST(DefaultCheckpoint, OfAnEarlierRunDoesNotOutliveTheStartOfAnother) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  Json scene = swinging_sheet(true);
  run_and_kill(scene, {.out = out, .checkpoint_seconds = 0}, 20);
  ASSERT_TRUE(std::filesystem::exists(Results(out).checkpoint));
  scene["gravity"] = {0, -1, 0};
  run_and_kill(scene, {.out = out}, 2);
  EXPECT_FALSE(std::filesystem::exists(Results(out).checkpoint));
}

TEST(Checkpoint, IsFlushedBeforeItTakesItsNameAndItsFolderAfterwards) {
  const TemporaryFolder folder;
  Simulation simulation(parsed(swinging_sheet(false)), {.threads = 1});
  std::vector<Flush> seen;
  flushed_name = folder / "checkpoint";
  flushes = &seen;
  simulation.save_checkpoint(flushed_name);
  flushes = nullptr;
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_FALSE(seen[0].folder);
  EXPECT_FALSE(seen[0].whole_there) << "a power failure leaves the old one or the new one";
  EXPECT_TRUE(seen[1].folder);
  EXPECT_TRUE(seen[1].whole_there);
}

TEST(FolderOfResults, ThatAnotherRunIsWritingIsRefusedAndLeftAlone) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const Json scene = swinging_sheet(false);
  const std::string expected =
      out + ": found another run that is writing to it; allowed: a folder of this run's own (--out)";
  const auto watch = [&](const Progress& now) {
    if (now.step != 3) return;
    const auto before = files_in(out);
    for (const bool resume : {false, true})
      EXPECT_EQ(refusal([&] { run_quietly(scene, {.out = out, .steps = 1, .resume = resume}); }), expected);
    EXPECT_EQ(refusal([&] { redraw(out, 1); }), expected);
    EXPECT_TRUE(files_in(out) == before);
  };
  run(parsed(scene), {.threads = 1}, {.out = out}, watch, std::atomic<bool>{false});
  EXPECT_EQ(run_quietly(scene, {.out = out}).failed_expectations.size(), 0u) << "and the next may have it";
}

TEST(FolderOfResults, IsFreeAgainAfterAKill) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  const std::vector<std::string> endless{"run", "scene.json", "--every", "1", "--steps", "100000000", "--out", "out"};
  MalhaProcess process(endless, folder / ".");
  while (process.running() && !std::filesystem::exists(folder / "out/frames/frame_000003.vtp"))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const Ended refused = malha_command({"run", "scene.json", "--steps", "1", "--out", "out"}, folder / ".");
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(refused.err.find("out: found another run that is writing to it"), 0u) << refused.err;
  process.send(SIGKILL);
  EXPECT_EQ(process.wait().status, -SIGKILL);
  EXPECT_EQ(malha_command({"run", "scene.json", "--steps", "1", "--out", "out"}, folder / ".").status, 0);
}

TEST(PicturesOfAStoppedRun, AreDrawnLaterAsTheRunWouldHaveDrawnThem) {
  for (const char* precision : {"float", "double"}) {
    const TemporaryFolder folder;
    Json scene = swinging_sheet(true, precision);
    scene["outputs"]["pictures"] = {{"size", {64, 48}}};
    scene["outputs"]["frames"] = {{"every", 1}, {"formats", {"vtp"}}};
    const std::string stopped = folder / "stopped", whole = folder / "whole";
    std::atomic<bool> stop{false};
    const auto stop_at_10 = [&stop](const Progress& now) { stop = now.step == 10; };
    EXPECT_TRUE(run(parsed(scene), {.threads = 1}, {.out = stopped}, stop_at_10, stop).pictures_missing);
    EXPECT_EQ(redraw(stopped, 1), "");
    run_quietly(scene, {.out = whole, .steps = 10});
    auto drawn = files_in(stopped), expected = files_in(whole);
    EXPECT_TRUE(drawn["picture.png"] == expected["picture.png"]);
    EXPECT_TRUE(drawn["storyboard.png"] == expected["storyboard.png"]);
    EXPECT_FALSE(expected["picture.png"].empty());
  }
}

TEST(PicturesOfAStoppedRun, AreLeftOutByCtrlCWhichSaysHowToGetThem) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(false);
  scene["outputs"]["pictures"] = {{"size", {64, 48}}};
  folder.write("scene.json", scene.dump());
  const std::vector<std::string> endless{"run",     "scene.json", "--every", "1",
                                         "--steps", "100000000",  "--out",   "an out"};
  MalhaProcess process(endless, folder / ".");
  while (process.running() && !std::filesystem::exists(folder / "an out/frames/frame_000003.vtp"))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  process.send(SIGINT);
  const Ended ended = process.wait();
  EXPECT_EQ(ended.status, 130);
  EXPECT_TRUE(has(ended.err, "pictures are left out; draw them with: malha picture 'an out'\n")) << ended.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "an out/picture.png"));
  EXPECT_EQ(Json::parse(bytes_of(folder / "an out/report.json"))["status"], "interrupted");
  const Ended drawn = malha_command({"picture", "an out"}, folder / ".");
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_TRUE(has(drawn.out, "\nstoryboard  an out/storyboard.png\n")) << drawn.out;
}

// Rendering a picture takes seconds where other programs use the cores.
TEST(PicturesOfAStoppedRun, AreLeftOutInTheMiddleOfOne) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(true);
  scene["outputs"]["pictures"] = {{"every", 1}, {"size", {64, 48}}};
  std::atomic<bool> stop{false};
  RunOptions options{.out = folder / "out"};
  options.on_activity = [&stop](const char* what) { stop = stop || what == std::string("drawing a picture"); };
  const auto quiet = [](const Progress&) {};
  EXPECT_TRUE(run(parsed(scene), {.threads = 1}, options, quiet, stop).pictures_missing);
  std::vector<std::string> names;
  for (const auto& [name, bytes] : files_in(folder / "out")) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"checkpoint.malha", "report.json"}));
}

// The run has done all its steps, and its pictures do not exist yet.
TEST(PicturesOfAStoppedRun, AreMissedInTheLastStepToo) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(true);
  scene["outputs"]["pictures"] = {{"every", 1}, {"size", {64, 48}}};
  std::atomic<bool> stop{false};
  RunOptions options{.out = folder / "out", .steps = 3};
  int drawn = 0;
  options.on_activity = [&](const char* what) {
    stop = stop || (what == std::string("drawing a picture") && ++drawn == 4);
  };
  const RunResult result = run(
      parsed(scene), {.threads = 1}, options, [](const Progress&) {}, stop);
  EXPECT_FALSE(result.interrupted);
  EXPECT_TRUE(result.pictures_missing);
  EXPECT_FALSE(std::filesystem::exists(folder / "out/storyboard.png"));
  EXPECT_EQ(Json::parse(bytes_of(folder / "out/report.json"))["status"], "finished");
}

// Before the first step nothing is lost, and a set-up may take long.
TEST(CtrlC, EndsASetUpAtOnceAndLeavesEarlierResults) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(false);
  folder.write("scene.json", scene.dump());
  ASSERT_EQ(malha_command({"run", "scene.json", "--steps", "2"}, folder / ".").status, 0);
  const auto before = files_in(folder / "out");
  scene["bodies"][0]["shape"]["grid"]["cells"] = {1500, 1500};
  folder.write("scene.json", scene.dump());
  MalhaProcess process({"run", "scene.json"}, folder / ".");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // the set-up takes some seconds
  process.send(SIGINT);
  EXPECT_EQ(process.wait().status, -SIGINT);
  EXPECT_TRUE(files_in(folder / "out") == before);
}

TEST(PicturesOfAStoppedRun, NeedNoFramesButTheStoryboardDoes) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  run_quietly(swinging_sheet(false), {.out = out, .steps = 3});
  EXPECT_EQ(redraw(out, 1), "no storyboard: it needs frames for ParaView (malha run --format vtp)");
  EXPECT_TRUE(std::filesystem::exists(Results(out).picture));
  for (const char* text : {"", "{", "[]", "{\"input\": {}}", "{\"input\": {\"folder\": 3, \"scene\": {}}}",
                           "{\"input\": {\"folder\": \"\", \"scene\": {}}}"}) {
    folder.write("out/report.json", text);
    EXPECT_NE(refusal([&] { redraw(out, 1); }).find("report.json: "), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace malha
