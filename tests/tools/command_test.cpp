// SPDX-License-Identifier: Apache-2.0
// The malha command from a user's view: its output, its exit status, and its files.
#include <pty.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <thread>

#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

class Command : public testing::Test {
 protected:
  Command() { write(scene_without_warnings()); }
  static Json scene_without_warnings() {
    Json scene = swinging_sheet(true);
    scene["solver"]["substeps"] = 10;  // so many that friction needs no warning
    return scene;
  }
  void write(const Json& scene) const { folder_.write("scene.json", scene.dump()); }
  Ended malha(const std::vector<std::string>& arguments) const { return malha_command(arguments, folder_ / "."); }
  Json report(const std::string& out = "out/scene") const {
    return Json::parse(bytes_of(folder_ / out / "report.json"));
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  TemporaryFolder folder_;
};

TEST_F(Command, RunsASceneAndSaysAtTheEndWhatAPersonWants) {
  Json scene = swinging_sheet(true);
  scene["outputs"]["pictures"] = {{"size", {64, 48}}};
  write(scene);
  const Ended ended = malha({"run", "scene.json", "--threads", "2", "--format", "vtp,pc2"});
  EXPECT_EQ(ended.status, 0) << ended.err;
  for (const char* line :
       {"simulated   0.8 s, 40 steps of 49 particles on 2 threads\n", "\nspeed       ", " ms a step",
        " times real time\n", "\nstrain      ", "\ncontacts    ", "\nreport      out/scene/report.json\n",
        "\npicture     out/scene/picture.png\n", "\nstoryboard  out/scene/storyboard.png\n",
        "\nframes      out/scene/frames/frames.pvd (ParaView)\n",
        "\nframes      out/scene/frames/points_sheet.pc2 with rest.obj (Blender, Maya)\n"})
    EXPECT_TRUE(has(ended.out, line)) << line << " is not in\n" << ended.out;
  EXPECT_EQ(report()["status"], "finished");
  EXPECT_TRUE(exists("out/scene/frames/frame_000040.vtp"));
}

TEST_F(Command, KeepsTheResultsOfAnyNameInTheirFolder) {
  for (const std::string name : {"...json", "..json", ".json", "a.b.json", "no_end"}) {
    folder_.write(name, swinging_sheet(false).dump());
    EXPECT_EQ(malha({"run", name, "--steps", "1", "--quiet"}).status, 0) << name;
  }
  std::set<std::string> here, results;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "."))
    here.insert(entry.path().filename().string());
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out"))
    if (std::filesystem::exists(entry.path() / "report.json")) results.insert(entry.path().filename().string());
  EXPECT_EQ(here, (std::set<std::string>{"...json", "..json", ".json", "a.b.json", "no_end", "out", "scene.json"}));
  EXPECT_EQ(results, (std::set<std::string>{"...json", "..json", ".json", "a.b", "no_end"}));
}

// Results do not reveal where they were made, and a folder that is moved keeps what it needs.
TEST_F(Command, LeavesNoPathsOfThisMachineInItsResults) {
  namespace fs = std::filesystem;
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"] = {{"mesh", "meshes/a.obj"}};
  scene["bodies"][0]["constraints"][0]["elements"] = {"edges"};
  fs::create_directories(folder_ / "tree/scenes/meshes"), fs::create_directory(folder_ / "elsewhere");
  folder_.write("tree/scenes/meshes/real", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3\nf 1 3 4\n");
  fs::create_symlink("real", folder_ / "tree/scenes/meshes/a.obj");  // the name of the link tells the format
  folder_.write("tree/scenes/scene.json", scene.dump());
  const std::string whole = fs::canonical(folder_ / ".").string();
  const auto run = [&](const std::string& file) {
    EXPECT_EQ(malha({"run", file, "--steps", "1", "--page", "--quiet", "--out", "tree/out"}).status, 0);
    EXPECT_EQ(report("tree/out")["input"]["scene"]["bodies"][0]["shape"]["mesh"], "../scenes/meshes/a.obj");
    for (const auto& [name, bytes] : files_in(folder_ / "tree/out"))
      EXPECT_FALSE(has(bytes, whole)) << name << " of " << file;
  };
  run("tree/scenes/scene.json");
  run(whole + "/tree/scenes/scene.json");
  fs::rename(folder_ / "tree", folder_ / "elsewhere/moved");
  fs::create_directory_symlink("elsewhere/moved/out", folder_ / "link");
  EXPECT_EQ(malha({"picture", "link"}).status, 0) << malha({"picture", "link"}).err;
  EXPECT_TRUE(exists("elsewhere/moved/out/picture.png"));
}

TEST_F(Command, MakesPicturesForASceneThatNamesNone) {
  EXPECT_EQ(malha({"run", "scene.json", "--steps", "1", "--picture"}).status, 0);
  EXPECT_TRUE(exists("out/scene/picture.png"));
  EXPECT_TRUE(exists("out/scene/storyboard.png"));
}

TEST_F(Command, SaysWhatTheSceneExpectsAndDidNotHappen) {
  Json scene = swinging_sheet(false);
  scene["expect"] = {{"max_speed", 0}};
  write(scene);
  const Ended ended = malha({"run", "scene.json"});
  EXPECT_EQ(ended.status, 1);
  EXPECT_TRUE(has(ended.err, "scene.json: not as expected: max_speed: found ")) << ended.err;
  EXPECT_EQ(malha({"run", "scene.json", "--seconds", "0.5"}).status, 0) << "the scene's end was not reached";
}

// 0.8 s in steps of 0.3 s are 2.67: three, to 0.9 s.
TEST_F(Command, SaysWhereATimeIsNotWholeSteps) {
  Json scene = swinging_sheet(false);
  scene["solver"]["dt"] = 0.3;
  write(scene);
  const auto expect_said = [&](const std::vector<std::string>& options, const std::string& rounding) {
    std::vector<std::string> words{"run", "scene.json", "--threads", "1"};
    words.insert(words.end(), options.begin(), options.end());
    const std::string said = malha(words).err;
    EXPECT_EQ(has(said, "are run, to"), !rounding.empty()) << said;
    EXPECT_TRUE(rounding.empty() || has(said, "scene.json: warning: " + rounding + "\n")) << said;
    EXPECT_EQ(has(report()["notes"].dump(), "are run, to"), !rounding.empty());
  };
  expect_said({}, "the duration, 0.8 s, is 2.66667 steps of 0.3 s: 3 are run, to 0.9 s");
  EXPECT_EQ(report()["step"], 3);
  expect_said({"--seconds", "0.5"}, "--seconds, 0.5 s, is 1.66667 steps of 0.3 s: 2 are run, to 0.6 s");
  EXPECT_EQ(report()["step"], 2);
  expect_said({"--seconds", "0.6"}, "");
  expect_said({"--steps", "2"}, "");
  scene["solver"]["dt"] = 0.0166667, scene["duration"] = 0.1;  // 6 steps, to six digits
  write(scene);
  expect_said({}, "");
}

TEST_F(Command, LetsOptionsWinOverTheScene) {
  Json scene = swinging_sheet(false);
  scene["outputs"] = {{"frames", {{"every", 1}, {"formats", {"vtp"}}}}, {"pictures", {{"size", {16, 16}}}}};
  write(scene);
  EXPECT_EQ(malha({"run", "scene.json", "--steps", "5", "--every", "2", "--format", "ply,obj", "--picture-every", "4"})
                .status,
            0);
  EXPECT_EQ(report()["step"], 5);
  for (const char* name : {"frames/frame_000002.ply", "frames/frame_000002.obj", "pictures/picture_000004.png"})
    EXPECT_TRUE(exists(std::string("out/scene/") + name)) << name;
  for (const char* name : {"frames/frame_000003.ply", "frames/frames.pvd", "pictures/picture_000002.png"})
    EXPECT_FALSE(exists(std::string("out/scene/") + name)) << name;

  EXPECT_EQ(malha({"run", "scene.json", "--seconds", "0.1", "--every", "0", "--no-picture", "--out", "bare"}).status,
            0);
  EXPECT_EQ(report("bare")["step"], 5) << "of 0.02 s";
  EXPECT_EQ(files_in(folder_ / "bare").size(), 2u) << "report and checkpoint";
}

TEST_F(Command, GivesTheSameBitsOnAnyThreadsAndBackend) {
  std::set<std::string> hashes;
  for (const std::vector<std::string>& how :
       {std::vector<std::string>{"--threads", "1"}, {"--threads", "64"}, {"--backend", "serial"}}) {
    std::vector<std::string> words{"run", "scene.json", "--quiet"};
    words.insert(words.end(), how.begin(), how.end());
    EXPECT_EQ(malha(words).status, 0);
    hashes.insert(report()["state_hash"]);
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST_F(Command, SaysNothingWhenQuiet) {
  const Ended ended = malha({"run", "scene.json", "--quiet"});
  EXPECT_EQ(ended.status, 0);
  EXPECT_EQ(ended.out + ended.err, "");
}

TEST_F(Command, ReportsItsProgressInPlainLinesWhereThereIsNoTerminal) {
  const Ended ended = malha({"run", "scene.json", "--threads", "1"});
  EXPECT_EQ(ended.err.find_first_of("\r\033"), std::string::npos);
  EXPECT_EQ(ended.err.find("step 4 of 40, t = 0.080 s, "), 0u) << ended.err;
  EXPECT_TRUE(has(ended.err, "\nstep 40 of 40, t = 0.800 s, ")) << ended.err;
  EXPECT_GE(std::count(ended.err.begin(), ended.err.end(), '\n'), 10);
}

/// The output of `malha run` with these options on a terminal of 100 columns; empty where there are no terminals.
std::string shown_on_a_terminal(const TemporaryFolder& folder, const std::vector<std::string>& options) {
  std::vector<std::string> words{MALHA_COMMAND, "run", folder / "scene.json", "--out", folder / "out",
                                 "--threads",   "1"};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int terminal = -1;
  winsize size{24, 100, 0, 0};
  const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
  if (child < 0) return "";
  if (child == 0) {
    execv(argv[0], argv.data());
    _exit(127);
  }
  std::string shown;
  char block[4096];
  for (ssize_t count; (count = read(terminal, block, sizeof block)) > 0;)
    shown.append(block, static_cast<std::size_t>(count));
  int state = 0;
  waitpid(child, &state, 0);
  close(terminal);
  EXPECT_EQ(WEXITSTATUS(state), 0) << shown;
  return shown;
}

TEST_F(Command, RenewsOneLineOnATerminal) {
  const std::string shown = shown_on_a_terminal(folder_, {});
  if (shown.empty()) GTEST_SKIP() << "no pseudo-terminal here: is /dev/pts mounted?";
  EXPECT_TRUE(has(shown, "\r[...")) << shown;
  EXPECT_TRUE(has(shown, "\r[##############################] 40/40  t = 0.800 s  ")) << shown;
  EXPECT_TRUE(has(shown, " steps/s  0:00 left\033[K\r\nsimulated   0.8 s")) << "the line is left before the results\n"
                                                                            << shown;
  EXPECT_EQ(shown.find('\n'), shown.find("\r\nsimulated") + 1) << "one line, however often it is drawn\n" << shown;
}

TEST_F(Command, SaysOnATerminalWhatItDoesThatIsNotAStep) {
  Json scene = scene_without_warnings();
  scene["outputs"]["pictures"] = {{"size", {32, 24}}};
  scene["outputs"]["checkpoint_every"] = 20;
  write(scene);
  const std::string shown = shown_on_a_terminal(folder_, {"--every", "40"});
  if (shown.empty()) GTEST_SKIP() << "no pseudo-terminal here: is /dev/pts mounted?";
  std::size_t at = 0;  // each line comes after the one before
  for (const char* what :
       {"] setting up: reading meshes, ", "] setting up: colouring and laying out, building trees", "] writing a frame",
        "] drawing a picture", "/40  t = 0.", "  writing a checkpoint", "/40  t = 0.", "  writing the report",
        "  writing the storyboard", "  drawing a picture", "] 40/40  t = 0.800 s  "}) {
    const std::size_t found = shown.find(what, at);
    ASSERT_NE(found, std::string::npos) << what << " is not after byte " << at << " of\n" << shown;
    at = found;
  }
  EXPECT_EQ(shown.find('\n'), shown.find("\r\nsimulated") + 1) << shown;
}

/// Runs until frame `frame` is there.
void wait_for_frame(MalhaProcess& process, const std::filesystem::path& frame) {
  while (process.running() && !std::filesystem::exists(frame))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

TEST_F(Command, StopsOnCtrlCWithACheckpointFromWhichItGoesOnWithTheVerySameBits) {
  const std::vector<std::string> words{"run",      "scene.json", "--threads", "1",
                                       "--format", "pc2,ply",    "--steps",   "100000000"};
  MalhaProcess process(words, folder_ / ".");
  wait_for_frame(process, folder_ / "out/scene/frames/frame_000007.ply");
  process.send(SIGINT);
  const Ended ended = process.wait();
  EXPECT_EQ(ended.status, 130) << ended.err;
  EXPECT_TRUE(has(ended.err,
                  "interrupted; go on with: malha run scene.json --threads 1 --format pc2,ply --steps "
                  "100000000 --resume\n"))
      << ended.err;
  EXPECT_TRUE(has(ended.out, "\nreport      out/scene/report.json\n")) << ended.out;
  EXPECT_EQ(report()["status"], "interrupted");
  const std::int64_t reached = report()["step"];
  EXPECT_GE(reached, 7);

  const std::string end = std::to_string(reached + 20);
  EXPECT_EQ(malha({"run", "scene.json", "--format", "pc2,ply", "--steps", end, "--resume", "--quiet"}).status, 0);
  EXPECT_EQ(malha({"run", "scene.json", "--format", "pc2,ply", "--steps", end, "--out", "whole", "--quiet"}).status, 0);
  EXPECT_EQ(report()["state_hash"], report("whole")["state_hash"]);
  EXPECT_TRUE(files_in(folder_ / "out/scene/frames") == files_in(folder_ / "whole/frames"));
}

TEST_F(Command, EndsAtOnceOnASecondCtrlC) {
  Json scene = swinging_sheet(false);
  scene["solver"]["substeps"] = 100000;  // a step that takes longer than the test waits
  scene["solver"]["iterations"] = 100000;
  write(scene);
  MalhaProcess process({"run", "scene.json", "--every", "1", "--threads", "1"}, folder_ / ".");
  wait_for_frame(process, folder_ / "out/scene/frames/frame_000000.vtp");
  // Before the step the first signal would end the run already. Reaching its frame and the step's start takes far less.
  for (const double then = process.cpu_seconds() + 0.5; process.running() && process.cpu_seconds() < then;)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  while (process.running()) {
    process.send(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const Ended ended = process.wait();
  EXPECT_EQ(ended.status, -SIGINT) << ended.err;
}

TEST_F(Command, ExitsWithThreeWhereTheRunDiverges) {
  // 2^59 s at 2^59 m/s: step 1024 reaches 2^128 m, which float does not hold.
  Json scene = Json::parse(R"({
    "name": "rush", "solver": {"type": "pbd", "substeps": 1}, "duration": 1,
    "bodies": [{"name": "comet", "mass": 1, "shape": {"lattice": {"min": [0,0,0], "max": [0,0,0], "count": [1,1,1]}}}]})");
  scene["solver"]["dt"] = 0x1p59;
  scene["bodies"][0]["velocity"] = {0x1p59, 0, 0};
  write(scene);
  const Ended ended = malha({"run", "scene.json", "--steps", "2000", "--every", "500", "--quiet"});
  EXPECT_EQ(ended.status, 3);
  EXPECT_EQ(ended.err.find("scene.json: diverged at step 1024 (t = "), 0u) << ended.err;
  EXPECT_TRUE(has(ended.err, "particle 0 of body 'comet'")) << ended.err;
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1);
  EXPECT_EQ(report()["status"], "diverged");
  EXPECT_TRUE(exists("out/scene/frames/frame_000002.vtp"));
}

TEST_F(Command, ExitsWithFourWhereItCannotWrite) {
  folder_.write("file", "not a folder");
  const Ended below_a_file = malha({"run", "scene.json", "--out", "file/out"});
  EXPECT_EQ(below_a_file.status, 4);
  EXPECT_EQ(below_a_file.err, "malha: file/out: cannot make the folder: Not a directory\n");

  // LLVM's OpenMP itself needs a file of 1024 bytes.
  const Ended full = MalhaProcess({"run", "scene.json", "--every", "1", "--quiet"}, folder_ / ".", 1024).wait();
  EXPECT_EQ(full.status, 4);
  EXPECT_EQ(full.err, "malha: out/scene/frames/frame_000000.vtp: cannot write: File too large\n");
  for (const auto& file : files_in(folder_ / "out")) EXPECT_FALSE(file.first.ends_with(".tmp")) << file.first;
}

TEST_F(Command, RefusesAResumeWithoutACheckpoint) {
  const Ended ended = malha({"run", "scene.json", "--resume"});
  EXPECT_EQ(ended.status, 2);
  EXPECT_EQ(ended.err.find("out/scene/checkpoint.malha: cannot read: "), 0u) << ended.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(Command, PlansAndChecksWithoutWriting) {
  const Ended plan = malha({"plan", "scene.json", "--threads", "3"});
  EXPECT_EQ(plan.status, 0);
  EXPECT_EQ(plan.err, "");
  for (const char* line : {"scene: swinging sheet\n", "\nthreads: 3\n", "\npatches:\n", "\n  distance: ", "\nmemory:\n",
                           "\nembree: yes\nenvironment_objects: 2\n"})
    EXPECT_TRUE(has(plan.out, line)) << line << " is not in\n" << plan.out;
  const Ended check = malha({"check", "scene.json"});
  EXPECT_EQ(check.status, 0);
  EXPECT_EQ(check.out, "scene.json: ok: 49 particles in 1 body\n");
  EXPECT_EQ(files_in(folder_ / ".").size(), 1u);
}

}  // namespace
}  // namespace malha
