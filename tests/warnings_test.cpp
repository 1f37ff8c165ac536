// What `malha run` and `plan` warn of, and what they do not: both sides of each known boundary.
#include "host/results/warnings.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

std::vector<std::string> warnings_of(const Scene& scene) { return warnings(Simulation(scene, {.threads = 1}).model()); }

/// One line, of this chart.
testing::AssertionResult warns_once(const Scene& scene, const std::string& chart) {
  const std::vector<std::string> lines = warnings_of(scene);
  if (lines.size() == 1 && has(lines[0], "(malha study stability, chart " + chart + ")"))
    return testing::AssertionSuccess();
  auto no = testing::AssertionFailure() << lines.size() << " lines";
  for (const std::string& line : lines) no << "\n" << line;
  return no;
}

/// n x n particles, 2 m x 2 m and 1 kg, horizontal at the start.
Scene sheet_of(int n, bool pinned, const SolverSpec& solver) {
  BodySpec body;
  body.name = "sheet", body.shape = GridShape{{2, 2}, {n - 1, n - 1}}, body.mass = 1;
  if (pinned) body.pins = {RowPin{}};
  body.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({body}, kEarth, 1.0 / 60);
  scene.solver = solver;
  return scene;
}

TEST(Warning, DoesNotComeWithDefaultSettings) {
  for (const char* type : {"pbd", "desbrun"})
    for (const bool pinned : {true, false}) {
      SolverSpec solver;
      solver.type = type;
      EXPECT_TRUE(warnings_of(sheet_of(33, pinned, solver)).empty()) << type;
    }
}

TEST(WarningOfSag, ComesWhereTheSheetDoesStretchByHalfAndNotWhereItDoesNot) {
  SolverSpec solver;
  solver.substeps = 1;
  const Scene bad = sheet_of(65, true, solver);
  EXPECT_TRUE(warns_once(bad, "masses"));
  EXPECT_GT(after(bad, 2).measure().strain_max, 0.5);
  EXPECT_TRUE(warnings_of(sheet_of(65, false, solver)).empty()) << "nothing holds it";
  solver.substeps = 10;
  const Scene good = sheet_of(65, true, solver);
  EXPECT_TRUE(warnings_of(good).empty());
  EXPECT_LT(after(good, 2).measure().strain_rms, 0.1);
}

TEST(WarningOfSag, ComesOfASoftPbdStiffnessAndGoesWithLongRangeAttachments) {
  Scene scene = sheet_of(17, true, {});
  scene.bodies[0].constraints[0].stiffness = 0.02;
  EXPECT_TRUE(warns_once(scene, "stiffness"));
  EXPECT_GT(after(scene, 2).measure().strain_max, 0.5);
  scene.bodies[0].constraints.push_back(stiff("long_range"));
  EXPECT_TRUE(warnings_of(scene).empty());
  scene.bodies[0].constraints = {compliant("distance", 1e-4, {"edges", "shear"})};
  EXPECT_TRUE(warnings_of(scene).empty());
}

TEST(WarningOfSag, NamesSubstepsThatAreEnough) {
  SolverSpec solver;
  solver.substeps = 1;
  Simulation simulation(sheet_of(65, true, solver), {.threads = 1});
  const double strain = worst_sag(simulation.model()).strain;
  solver.substeps = static_cast<int>(std::ceil(std::sqrt(strain / 0.5)));
  EXPECT_TRUE(has(warnings(simulation.model())[0], "take " + std::to_string(solver.substeps) + " substeps or more"));
  EXPECT_TRUE(warnings_of(sheet_of(65, true, solver)).empty());
}

TEST(WarningOfRounding, ComesWhereFloatGainsTheEnergyThatItSays) {
  BodySpec chain = hung_chain({0, 0, 0}, {1, 0, 0}, 20, 0.01);
  chain.constraints = {stiff("distance", {"edges"})};
  Scene scene = scene_of({chain}, kEarth, 1.0 / 60, 4096, Precision::Float);
  scene.duration = 2;
  EXPECT_TRUE(warns_once(scene, "masses"));
  scene.solver.precision = Precision::Double;
  EXPECT_TRUE(warnings_of(scene).empty());
  scene.solver.precision = Precision::Float, scene.solver.substeps = 512;
  EXPECT_TRUE(warnings_of(scene).empty());
}

TEST(WarningOfDistance, ComesFarFromTheOriginInFloatAlone) {
  Scene scene = sheet_of(33, false, {});
  scene.bodies[0].transform.translate = {0, 2000, 0};
  EXPECT_TRUE(warns_once(scene, "distance"));
  scene.solver.precision = Precision::Double;
  EXPECT_TRUE(warnings_of(scene).empty());
}

TEST(WarningOfTorque, ComesOfOtherCorrectorsOfStiffFreeBodies) {
  SolverSpec solver;
  solver.type = "desbrun", solver.substeps = 1;
  for (const Corrector corrector : {Corrector::Paper, Corrector::Off}) {
    solver.desbrun.corrector = corrector;
    Scene scene = sheet_of(9, false, solver);  // 10 kN/m: k h^2 / m is about 200
    EXPECT_TRUE(warns_once(scene, "torque"));
    EXPECT_TRUE(warnings_of(sheet_of(9, true, solver)).empty()) << "held";
    scene.solver.desbrun.stiffness = corrector == Corrector::Paper ? 0.1 : 1;
    EXPECT_TRUE(warnings_of(scene).empty());
  }
  solver.desbrun.corrector.reset(), solver.desbrun.refine = 4;  // off, then
  EXPECT_TRUE(warns_once(sheet_of(9, false, solver), "torque"));
}

TEST(WarningOfWeight, ComesWhereInternalForcesAloneAreFilteredAtLargeSteps) {
  SolverSpec solver;
  solver.type = "desbrun", solver.substeps = 1, solver.dt = 0.1, solver.desbrun.internal_only = true;
  EXPECT_TRUE(warns_once(sheet_of(17, true, solver), "weight"));
  EXPECT_TRUE(warnings_of(sheet_of(17, false, solver)).empty()) << "nothing is pinned";
  solver.dt = 1.0 / 60;
  EXPECT_TRUE(warnings_of(sheet_of(17, true, solver)).empty());
  solver.dt = 0.1, solver.desbrun.internal_only = false;
  EXPECT_TRUE(warnings_of(sheet_of(17, true, solver)).empty());
}

/// Of the shipped scenes only the cloth that is there to show it: without its attachments it stretches by 67 %.
TEST(Warning, ComesOfOneShippedScene) {
  for (const char* name : {"sheet_shear", "flag", "turning_flag", "carried_sheet", "torn_sheet", "desbrun_sheet",
                           "pendulum", "oscillator", "cantilever", "balloon"})
    EXPECT_TRUE(warnings_of(load_shipped(name)).empty()) << name;
  const std::vector<std::string> lines = warnings_of(load_shipped("long_cloth"));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0],
            "body 'not held': with 2 substeps of 1 iteration what is next to its pins stretches by some 58 % under its "
            "weight; take 3 substeps or more, or \"long_range\" (malha study stability, chart masses)");
}

TEST(Warning, IsALineOnStandardErrorOfRunAndPlanUnlessTheyAreToBeQuiet) {
  SolverSpec solver;
  solver.substeps = 1;
  const TemporaryFolder folder;
  folder.write("scene.json", to_json(sheet_of(65, true, solver)));
  const std::string start =
      "scene.json: warning: body 'sheet': with 1 substep of 1 iteration what is next to its pins stretches by ";
  const Ended plan = malha_command({"plan", "scene.json"}, folder / ".");
  EXPECT_EQ(plan.status, 0);
  EXPECT_EQ(plan.err.find(start), 0u) << plan.err;
  EXPECT_EQ(std::count(plan.err.begin(), plan.err.end(), '\n'), 1);
  const Ended run = malha_command({"run", "scene.json", "--steps", "1"}, folder / ".");
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err.find(start), 0u) << run.err;
  EXPECT_EQ(malha_command({"run", "scene.json", "--steps", "1", "--quiet"}, folder / ".").err, "");
}

}  // namespace
}  // namespace malha
