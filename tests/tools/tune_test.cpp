// SPDX-License-Identifier: Apache-2.0
// malha tune finds settings that reach the error, and writes nothing if there are none.
#include "tools/tune/tune.h"

#include <cmath>

#include "tests/run_scenes.h"
#include "tests/small_scenes.h"
#include "tests/support.h"
#include "tools/tune/report.h"

namespace malha::tuning {
namespace {

/// A net of springs, pinned at one side, whose motion converges.
Json springy_net() {
  return Json::parse(R"({
    "name": "net", "solver": {"type": "pbd", "dt": 0.02, "substeps": 2}, "gravity": [0, -9.81, 0], "duration": 0.2,
    "bodies": [{"name": "net", "mass": 0.2, "shape": {"grid": {"size": [1, 1], "cells": [6, 6]}},
                "pins": [{"row": "first"}],
                "constraints": [{"type": "distance", "elements": ["edges", "shear"], "compliance": 0.001}]}]})");
}

/// The RMS distance from a reference at the end: the limit of backward Euler, with many small substeps in double.
double error_at_the_end(const Scene& scene) {
  Scene exact = parsed(springy_net());
  exact.solver.precision = Precision::Double, exact.solver.substeps = 4000;
  const std::vector<Vec3> truth = after(exact, scene.duration).positions(),
                          x = after(scene, scene.duration).positions();
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int k = 0; k < 3; ++k) sum += (x[i][k] - truth[i][k]) * (x[i][k] - truth[i][k]);
  return std::sqrt(sum / static_cast<double>(x.size()));
}

TuneResult tuned_quietly(const Json& scene, double error) {
  const std::atomic<bool> no_stop{false};
  return tune(parsed(scene), {.error = error, .threads = 1}, {}, no_stop);
}

/// The fewest substeps with which a method reached the error; 0 if it did not.
int fewest(const TuneResult& tuned, const std::string& method) {
  int least = 0;
  for (const TuneTrial& trial : tuned.trials)
    if (trial.reaches() && trial.method == method && (least == 0 || trial.scene.solver.substeps < least))
      least = trial.scene.solver.substeps;
  return least;
}

class TuneCommand : public testing::Test {
 protected:
  TuneCommand() { write(springy_net()); }
  void write(const Json& scene) const { folder_.write("net.json", scene.dump()); }
  Ended tune(std::vector<std::string> more) const {
    more.insert(more.begin(), {"tune", "net.json", "--threads", "1"});
    return malha_command(more, folder_ / ".");
  }
  TemporaryFolder folder_;
};

TEST_F(TuneCommand, WritesASceneThatReachesTheErrorWhenItRunsAgain) {
  const double error = 0.002;
  EXPECT_GT(error_at_the_end(parsed(springy_net())), error) << "as it is it does not";
  const Ended ended = tune({"--error", "0.002", "--json", "trials.json"});
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_TRUE(has(ended.out, "\n* ") && has(ended.out, "\nbest        ")) << ended.out;
  EXPECT_TRUE(has(ended.out, "\nscene       out/net_tuned.json\n")) << ended.out;
  const std::string file = folder_ / "out/net_tuned.json";
  EXPECT_EQ(malha_command({"check", file}, folder_ / ".").status, 0);
  EXPECT_LT(error_at_the_end(load_scene(file)), error);
  const Json trials = Json::parse(bytes_of(folder_ / "trials.json"));
  EXPECT_EQ(trials["error_m"], error);
  EXPECT_EQ(trials["trials"][trials["best"].get<std::size_t>()]["found"], "reaches");
}

TEST(Tune, TakesNoMoreSubstepsForALooserError) {
  const TuneResult strict = tuned_quietly(springy_net(), 0.004), loose = tuned_quietly(springy_net(), 0.016);
  ASSERT_TRUE(strict.best && loose.best);
  for (const TuneTrial& trial : strict.trials)
    // On a busy machine another method may be given up as too expensive.
    if (const int substeps = fewest(loose, trial.method); trial.reaches() && substeps > 0) {
      EXPECT_LE(substeps, fewest(strict, trial.method)) << trial.method;
    }
}

TEST(Tune, StatesErrorsThatAreThoseOfItsTrials) {
  const TuneResult tuned = tuned_quietly(springy_net(), 0.004);
  ASSERT_TRUE(tuned.best);
  const TuneTrial& best = tuned.trials[*tuned.best];
  EXPECT_LE(best.error, 0.004);
  // The worst of four moments, one of which is the end.
  EXPECT_GE(best.error + tuned.reference.error_bound, error_at_the_end(best.scene) - tuned.reference.error_bound);
}

TEST(Tune, TriesBothMethodsOnSprings) {
  const TuneResult tuned = tuned_quietly(springy_net(), 0.016);
  EXPECT_TRUE(tuned.left_out.empty());
  bool xpbd = false, desbrun = false;
  for (const TuneTrial& trial : tuned.trials) {
    xpbd = xpbd || trial.method.starts_with("XPBD");
    desbrun = desbrun || trial.method.starts_with("Desbrun");
  }
  EXPECT_TRUE(xpbd && desbrun);
}

/// A strip of 64 cells hangs by its end. It is at rest, and stays so in the limit of many substeps; with few substeps
/// its stiffness of 1 lets it stretch.
TEST(Tune, FindsThatLevelsReachTheErrorWithFewerSubstepsWhereTheWayToThePinsIsLong) {
  Json scene = springy_net();
  scene["duration"] = 0.4, scene["bodies"][0]["shape"]["grid"] = {{"size", {0.03, 1}}, {"cells", {2, 64}}};
  scene["bodies"][0]["transform"] = {{"rotate", {{"axis", {1, 0, 0}}, {"degrees", 90}}}};
  scene["bodies"][0]["constraints"][0] = {{"type", "distance"}, {"elements", {"edges", "shear"}}};
  const TuneResult tuned = tuned_quietly(scene, 0.01);
  ASSERT_TRUE(tuned.reference.converged);
  const int without = fewest(tuned, "PBD, 1 iteration, float"), with = fewest(tuned, "PBD, 1 iteration, levels, float");
  ASSERT_GT(with, 0);
  EXPECT_TRUE(without == 0 || with < without) << with << " " << without;
  for (const TuneTrial& trial : tuned_quietly(springy_net(), 0.016).trials)
    EXPECT_FALSE(has(trial.method, "levels")) << "they would not act on the small net";
}

TEST(Tune, KeepsTheSpringsOfDesbrunsMethodByPbd) {
  Json scene = springy_net();
  scene["bodies"][0]["constraints"][0] = {{"type", "distance"}, {"stiffness", 0.5}};
  scene["solver"] = {{"type", "desbrun"}, {"dt", 0.02}, {"spring_constant", 2000}};
  std::string why;
  const Scene other = to_pbd(parsed(scene), why);
  EXPECT_EQ(why, "");
  EXPECT_EQ(other.solver.type, "pbd");
  EXPECT_EQ(other.bodies[0].constraints[0].compliance, 1.0 / 1000);
  scene["bodies"][0]["constraints"].push_back({{"type", "bending"}});
  to_pbd(parsed(scene), why);
  EXPECT_TRUE(has(why, "bending")) << "as many stiffnesses as hinges";
}

TEST(Tune, GivesUpOnMotionThatDoesNotConverge) {
  Json scene = springy_net();  // a double pendulum of many links, whose motion is chaotic
  scene["bodies"][0] = {{"name", "chain"},
                        {"mass", 1},
                        {"shape", {{"chain", {{"from", {0, 0, 0}}, {"to", {0, 1, 0}}, {"segments", 8}}}}},
                        {"pins", {{{"particles", {0}}}}},
                        {"spin", {0, 0, 9}},
                        {"constraints", {{{"type", "distance"}}}}};
  scene["duration"] = 3;
  const std::atomic<bool> no_stop{false};
  const TuneOptions options{.error = 1e-5, .seconds = 3, .threads = 1};
  const TuneResult tuned = tune(parsed(scene), options, {}, no_stop);
  EXPECT_FALSE(tuned.reference.converged);
  EXPECT_FALSE(tuned.best);
  EXPECT_TRUE(tuned.trials.empty());
  EXPECT_TRUE(has(why_not_tuned(tuned, options), "did not converge"));
}

TEST_F(TuneCommand, LeavesTheFileOfBeforeWhereNothingIsFound) {
  Json scene = springy_net();
  scene["bodies"][0]["spin"] = {0, 0, 60};
  scene["bodies"][0]["pins"] = Json::array();
  write(scene);
  folder_.write("tuned.json", "what was there\n");
  const Ended ended = tune({"--error", "1e-13", "--out", "tuned.json"});
  EXPECT_EQ(ended.status, 1) << ended.out;
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
  EXPECT_EQ(ended.err.find("net.json: "), 0u) << ended.err;
  EXPECT_EQ(bytes_of(folder_ / "tuned.json"), "what was there\n");
  EXPECT_EQ(files_in(folder_ / ".").size(), 2u);
}

TEST_F(TuneCommand, RefusesWhatCannotBeTunedBeforeItRunsAnything) {
  const std::string see = "; see malha tune --help\n";
  EXPECT_EQ(tune({}).err, "malha tune: --error is required" + see);
  EXPECT_EQ(tune({"--error", "0"}).err, "malha tune: --error: found \"0\"; allowed: a number > 0 (m)" + see);
  EXPECT_EQ(tune({"--error", "nan"}).err, "malha tune: --error: found \"nan\"; allowed: a number > 0 (m)" + see);
  EXPECT_EQ(tune({"--error", "1", "--seconds", "-1"}).err,
            "malha tune: --seconds: found \"-1\"; allowed: a number > 0 (s)" + see);
  Ended ended = tune({"--error", "0.01", "--out", "both.json", "--json", "./both.json"});
  EXPECT_EQ(ended.status, 2);
  EXPECT_EQ(ended.err,
            "malha tune: --json: found './both.json', which is to be the tuned scene; allowed: another file\n");
  ended = tune({"--error", "0.01", "--seconds", "42949672960"});
  EXPECT_EQ(ended.status, 2);
  EXPECT_EQ(ended.err,
            "malha tune: --seconds: found 4.29497e+10 s, which are 2.14748e+12 steps of 0.02 s; allowed: at most 1e+09 "
            "steps\n");
  Json scene = springy_net();
  scene["bodies"][0]["tear"] = {{"strain", 0.5}};
  write(scene);
  ended = tune({"--error", "0.01"});
  EXPECT_EQ(ended.status, 2);
  EXPECT_EQ(ended.err, "net.json: found 'net', which tears; allowed: bodies that keep their particles (no \"tear\")\n");
  scene = springy_net();
  scene["solver"] = {{"type", "desbrun"}, {"dt", 0.02}, {"time_budget", 0.01}};
  write(scene);
  EXPECT_EQ(tune({"--error", "0.01"}).status, 2);
  EXPECT_EQ(files_in(folder_ / ".").size(), 1u) << "nothing is written";
}

TEST_F(TuneCommand, KeepsThePathsToMeshes) {
  std::filesystem::create_directories(folder_ / "scenes/meshes");
  folder_.write("scenes/meshes/strip.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 2 3\nf 2 4 3\n");
  Json scene = springy_net();
  scene["bodies"][0]["shape"] = {{"mesh", "meshes/strip.obj"}};
  scene["bodies"][0]["pins"] = {{{"particles", {0}}}};
  folder_.write("scenes/strip.json", scene.dump());
  const Ended ended = malha_command({"tune", "scenes/strip.json", "--error", "0.01", "--threads", "1"}, folder_ / ".");
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_EQ(malha_command({"check", "out/strip_tuned.json"}, folder_ / ".").status, 0);
}

TEST_F(TuneCommand, StopsOnCtrlC) {
  Json scene = springy_net();
  scene["duration"] = 1000;
  write(scene);
  MalhaProcess process({"tune", "net.json", "--error", "1e-9", "--seconds", "1000"}, folder_ / ".");
  usleep(300'000);
  process.send(SIGINT);
  const Ended ended = process.wait();
  EXPECT_EQ(ended.status, 130) << ended.err;
  EXPECT_TRUE(has(ended.err, "interrupted; nothing was written\n")) << ended.err;
  EXPECT_TRUE(files_in(folder_ / "out").empty());
}

}  // namespace
}  // namespace malha::tuning
