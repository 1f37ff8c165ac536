// SPDX-License-Identifier: Apache-2.0
// Softening by too few substeps: when `malha run` and `plan` warn that sheets are softer than their material.
#include "host/model/softening.h"

#include <gtest/gtest.h>

#include "host/model/model.h"
#include "host/report/warnings.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

std::vector<std::string> softening_warnings(const Scene& scene) {
  std::vector<std::string> lines = warnings(Simulation(scene, {.threads = 1}).model());
  // Hinges on irregular triangles are another material by direction, for which there is a warning too.
  std::erase_if(lines, [](const std::string& line) { return has(line, "as its \"rigidity\" says"); });
  return lines;
}

/// A strip of 0.2 m, damped by drag, that sags below the level or is stretched in its plane, by about a tenth or a
/// fiftieth of its length.
struct SoftStrip {
  const char* name;
  ConstraintSpec material;
  bool irregular;
  int substeps;  // with which it deforms by a third too much, by the warning's estimate
};

Scene scene_of_strip(const SoftStrip& strip, const TemporaryFolder& folder) {
  const bool stretched = strip.material.type == "membrane";
  const int columns = 4, rows = 9;
  const double width = 0.2 * columns / rows, mass = 0.2 * width * 0.2;
  BodySpec body;
  body.name = "strip", body.mass = mass, body.constraints = {strip.material};
  if (strip.irregular)
    body.shape = MeshFile{folder.write("strip.obj", irregular_obj(width, 0.2, columns, rows, 0.3, 5, 1))};
  else
    body.shape = GridShape{{width, 0.2}, {columns, rows}};
  if (!stretched) {
    body.constraints.push_back(stiff("distance", {"edges"}));
    if (!strip.irregular) body.constraints.back().elements.push_back("shear");
  }
  ListPin rim;
  for (int i = 0; i < (stretched ? 1 : 2) * (columns + 1); ++i) rim.particles.push_back(i);
  body.pins = {rim};
  Scene scene = scene_of({body}, stretched ? Vec3{0, 0, 0.4} : Vec3{0, -0.3, 0}, 1.0 / 60, strip.substeps);
  scene.solver.bending = BendingMethod::Projected;
  scene.wind = Wind{};
  scene.wind->drag = 10 * mass / ((rows + 1) * (columns + 1));
  return scene;
}

/// The mean displacement of its particles by gravity in 3 s, m.
double given_way(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  const double before = simulation.measure().potential;
  run_for(simulation, scene, 3);
  return (before - simulation.measure().potential) / (length(scene.gravity) * *scene.bodies[0].mass);
}

TEST(WarningOfSoftening, ComesWhereTooFewSubstepsMakeASheetSoftAndNamesSubstepsThatAreEnough) {
  const TemporaryFolder folder;
  ConstraintSpec hinges = stiff("bending"), folds = stiff("isometric_bending"), plate = stiff("plate", {}, 1, 0),
                 membrane = stiff("membrane", {}, 1, 0.3), softer = compliant("bending", 1000);
  for (ConstraintSpec* spec : {&hinges, &folds, &plate}) spec->rigidity = 1e-3;
  membrane.young_modulus = 2;
  for (const SoftStrip& strip : {SoftStrip{"hinges", hinges, false, 6},
                                 {"folds", folds, false, 6},
                                 {"plate", plate, false, 8},
                                 {"membrane", membrane, false, 3},
                                 {"irregular hinges", hinges, true, 10},
                                 {"irregular plate", plate, true, 8},
                                 {"irregular membrane", membrane, true, 3},
                                 {"compliance", softer, false, 9}}) {
    Scene scene = scene_of_strip(strip, folder);
    const std::vector<std::string> lines = softening_warnings(scene);
    ASSERT_EQ(lines.size(), 1u) << strip.name;
    EXPECT_TRUE(has(lines[0], "its \"" + strip.material.type + "\" deforms ")) << lines[0];
    const double soft = given_way(scene);
    const int enough = std::stoi(lines[0].substr(lines[0].find("take ") + 5));
    scene.solver.substeps = enough;
    EXPECT_TRUE(softening_warnings(scene).empty()) << strip.name;
    const double better = given_way(scene);
    scene.solver.substeps = 5 * enough;  // of a second order: right to a 25th of a tenth
    const double right = given_way(scene);
    EXPECT_GT(soft, 1.03 * right) << strip.name << ": the warning foretells up to four times as much";
    EXPECT_LT(better, 1.1 * right) << strip.name;
    if (testing::FLAGS_gtest_also_run_disabled_tests)
      std::printf("%-20s %2d substeps: %.3f, %3d: %.3f; %s\n", strip.name, strip.substeps, soft / right - 1, enough,
                  better / right - 1, lines[0].c_str());
    scene.solver.substeps = strip.substeps, scene.solver.iterations = 4;
    EXPECT_TRUE(softening_warnings(scene).empty()) << strip.name;
    EXPECT_LT(given_way(scene), 1.1 * right) << strip.name;
  }
}

TEST(WarningOfSoftening, DoesNotComeOfAStiffnessOrByDesbrunsMethod) {
  const TemporaryFolder folder;
  Scene scene = scene_of_strip({"stiff", stiff("bending"), false, 1}, folder);
  scene.solver.substeps = 6;
  EXPECT_TRUE(softening_warnings(scene).empty());
  scene.bodies[0].constraints = {stiff("distance", {"edges"}, 0.01), compliant("bending", 1e-3)};
  scene.solver.type = "desbrun", scene.gravity = {};
  EXPECT_TRUE(softening_warnings(scene).empty());
}

TEST(WarningOfSoftening, DoesNotComeOfShippedScenes) {
  for (const char* name : {"balloon", "balloon_low", "balloon_high", "carried_sheet", "torn_sheet", "turning_flag"})
    EXPECT_LE(worst_softening(build_model(load_shipped(name))).share, 0.1) << name;
}

}  // namespace
}  // namespace malha
