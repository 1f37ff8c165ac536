// SPDX-License-Identifier: Apache-2.0
// report.json: every promised number is present, under its name, and is plausible or exact.

#include "host/base/build_info.h"
#include "host/report/warnings.h"
#include "host/run/summary.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A soft balloon that presses on the ground beside a sheet that hangs by a row: every kind of constraint.
Json everything() {
  return Json::parse(R"({
    "name": "everything",
    "solver": {"type": "pbd", "dt": 0.02, "substeps": 4, "iterations": 2, "precision": "double"},
    "gravity": [0, -9.81, 0],
    "bodies": [
      {"name": "balloon", "shape": {"sphere": {"radius": 0.5, "subdivisions": 2}}, "mass": 0.3, "damping": 0.1,
       "transform": {"translate": [0, 0.492, 0]},
       "constraints": [{"type": "distance", "elements": ["edges"], "compliance": 0.001}, {"type": "bending", "stiffness": 0.1},
                       {"type": "pressure", "volume_ratio": 1.1}]},
      {"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [4, 4]}}, "density": 0.2,
       "transform": {"translate": [2, 1, 0]}, "pins": [{"row": "first"}],
       "constraints": [{"type": "distance", "elements": ["edges"]}, {"type": "distance_limit", "elements": ["shear"], "limit": 0.1}]}
    ],
    "environment": [{"name": "ground", "shape": {"box": {"size": [6, 1, 6], "cells": [1, 1, 1]}}, "friction": 0.5,
                     "transform": {"translate": [0, -0.5, 0]}, "thickness": 0.01}],
    "duration": 1
  })");
}

Json report_of(const Json& scene, int steps, const SimulationOptions& options = {.threads = 1}) {
  Simulation simulation(parsed(scene), options);
  for (int i = 0; i < steps; ++i) simulation.step();
  return Json::parse(simulation.report("finished"));
}

TEST(Report, SaysWhatRanOnWhat) {
  const Json report = report_of(everything(), 1, {.threads = 3});
  EXPECT_EQ(report["scene"], "everything");
  EXPECT_EQ(report["status"], "finished");
  ASSERT_EQ(report["notes"].size(), 1);  // one of its points is below the surface
  EXPECT_TRUE(has(report["notes"][0].get<std::string>(), "body 'balloon' starts up to "));
  EXPECT_EQ(report["malha_version"], version());
  EXPECT_EQ(report["compiler"], compiler());
  EXPECT_NE(report["compiler"].get<std::string>().find_first_of("0123456789"), std::string::npos);
  EXPECT_NE(report["flags"].get<std::string>().find("-ffp-contract=off"), std::string::npos);
  EXPECT_FALSE(report["cpu"].get<std::string>().empty());
  EXPECT_EQ(report["threads"], 3);
  EXPECT_EQ(report["solver"], Json::parse(R"({"type": "pbd", "precision": "double", "dt_s": 0.02, "substeps": 4,
                                              "iterations": 2})"));
  EXPECT_EQ(report_of(swinging_sheet(false, "float"), 1)["solver"]["precision"], "float");
  EXPECT_EQ(report_of(everything(), 1, {.backend = Backend::Serial})["threads"], 1);
}

TEST(Report, CountsParticlesConstraintsAndBatchesOfEveryKind) {
  const Json report = report_of(everything(), 1), kinds = report["constraints"];
  EXPECT_EQ(report["particles"], 162 + 25);
  ASSERT_EQ(kinds.size(), 4u);
  EXPECT_EQ(kinds["distance"]["count"], 480 + 40 - 4) << "the four edges of the pinned row could move nothing";
  EXPECT_EQ(kinds["bending"]["count"], 480);
  EXPECT_EQ(kinds["distance_limit"]["count"], 2 * 16);
  EXPECT_EQ(kinds["pressure"], Json::parse(R"({"count": 1})"));
  // At least as many batches as constraints that meet in a particle: 6 edges, and as many hinges as edges around a
  // particle and opposite to it, 6 + 6.
  EXPECT_GE(kinds["distance"]["max_colors_per_patch"], 6);
  EXPECT_GE(kinds["bending"]["max_colors_per_patch"], 12);
  EXPECT_GE(kinds["distance_limit"]["max_colors_per_patch"], 4);
  for (const char* kind : {"distance", "bending", "distance_limit"}) {
    EXPECT_GE(kinds[kind]["contiguous"], 0) << kind;
    EXPECT_LE(kinds[kind]["contiguous"], kinds[kind]["count"]) << kind;
  }
  EXPECT_EQ(report["zero_area_faces_dropped"], 0);
}

TEST(Report, CountsPatches) {
  Json scene = swinging_sheet(false);
  for (const int cells : {6, 45}) {  // one patch and several
    scene["bodies"][0]["shape"]["grid"]["cells"] = {cells, cells};
    const Json patches = report_of(scene, 1)["patches"];
    const bool one = cells == 6;
    EXPECT_EQ(patches["count"] == 1, one) << patches;
    EXPECT_EQ(patches["patch_colors"] == 1, one) << patches;
    EXPECT_EQ(patches["particles_shared"] == 0, one) << patches;
    EXPECT_LE(patches["soa_patches"], patches["count"]) << patches;
    EXPECT_GE(patches["max_patch_slots"].get<int>() * patches["count"].get<int>(), (cells + 1) * (cells + 1))
        << patches;
  }
}

TEST(Report, TimesSetUpStepsAndPassesWithinEachOther) {
  const int steps = 5;
  const Json report = report_of(everything(), steps), setup = report["setup_s"], timing = report["timing"];
  const auto sum = [&setup](const std::vector<const char*>& parts) {
    double all = 0;
    for (const char* part : parts) {
      EXPECT_GT(setup[part], 0) << part;
      all += setup[part].get<double>();
    }
    return all;
  };
  const double rounding = 1 + 1e-12;
  EXPECT_LE(sum({"load", "order", "build_constraints", "patches"}), setup["model"].get<double>() * rounding);
  EXPECT_LE(sum({"model", "colour", "layout", "collision"}), setup["total"].get<double>() * rounding);
  EXPECT_LE(setup["constraints"].get<double>(), sum({"colour", "layout"}) * rounding);

  EXPECT_EQ(timing["steps"], steps);
  EXPECT_GT(timing["step_ms_min"], 0);
  EXPECT_LE(timing["step_ms_min"], timing["step_ms_median"]);
  EXPECT_LE(timing["step_ms_median"], timing["step_ms_max"]);
  double passes = 0;
  for (const char* pass :
       {"damping_ms", "prediction_ms", "collision_ms", "projection_ms", "pressure_ms", "contact_ms", "state_ms"}) {
    ASSERT_TRUE(timing["step_ms_by_pass"].contains(pass)) << pass;
    EXPECT_GT(timing["step_ms_by_pass"][pass], 0) << pass;
    passes += timing["step_ms_by_pass"][pass].get<double>();
  }
  EXPECT_EQ(timing["step_ms_by_pass"].size(), 7u);
  // A step projects 516 + 480 + 32 constraints there and back, and 1, in each of 4 x 2 iterations.
  const double mean_step_ms = timing["ns_per_projection"].get<double>() * 8 * (2 * 1028 + 1) * 1e-6;
  EXPECT_GE(mean_step_ms * rounding, timing["step_ms_min"]);
  EXPECT_LE(mean_step_ms, timing["step_ms_max"].get<double>() * rounding);
  EXPECT_LE(passes, mean_step_ms * rounding);
}

TEST(Report, HasNoPassesNoProjectionsAndNoStrainWhereTheSceneHasNone) {
  const Json scene = Json::parse(R"({
    "name": "dust", "solver": {"type": "pbd", "dt": 0.01}, "duration": 1,
    "bodies": [{"name": "dust", "mass": 1, "shape": {"lattice": {"min": [0,0,0], "max": [1,1,1], "count": [3,3,3]}}}]})");
  const Json report = report_of(scene, 2);
  EXPECT_EQ(report["constraints"], Json::object());
  EXPECT_EQ(report["timing"]["step_ms_by_pass"].size(), 1u) << report["timing"];
  EXPECT_TRUE(report["timing"]["step_ms_by_pass"].contains("fused_solve_ms")) << report["timing"];
  EXPECT_FALSE(report["timing"].contains("ns_per_projection"));
  EXPECT_FALSE(report["state"].contains("strain_rms"));
  EXPECT_FALSE(report["state"].contains("volume_ratios"));
  EXPECT_EQ(report["memory"]["constraints_bytes"], 0);
  EXPECT_EQ(report["memory"]["collision_bytes"], 0);
  EXPECT_EQ(report_of(scene, 0)["timing"], Json::parse(R"({"steps": 0})"));
}

TEST(Report, CountsBytes) {
  const Json memory = report_of(everything(), 1)["memory"];
  EXPECT_GE(memory["particles_bytes"], 187 * 10 * 8) << "x, v, p and w in doubles";
  // Full packs, one to spare, and one against conflicts; a thread's sums of damped bodies; and forces and energies of
  // the check for divergence, which steps do not allocate.
  EXPECT_LE(memory["particles_bytes"], (187 + 47) * 10 * 8 + 6200);
  // At least one number of each constraint; the ground's 8 points and 12 triangles.
  EXPECT_GE(memory["constraints_bytes"], (516 + 32 + 480) * 8);
  EXPECT_GT(memory["patches_bytes"], 0);
  EXPECT_GE(memory["collision_bytes"], 8 * 3 * 4 + 12 * 3 * 4);
  // The user's points and the solver's in doubles, inverse masses, numbers; two particles a constraint, or four.
  EXPECT_GE(memory["model_bytes"], 187 * (24 + 24 + 8 + 4) + (516 + 32) * 8 + 480 * 16);
  double listed = 0;
  for (const auto& [key, bytes] : memory.items())
    if (key.ends_with("_bytes")) listed += bytes.get<double>();
  EXPECT_GT(memory["peak_mib"], listed / 1048576);
}

TEST(Report, ListsLevelsWhereThereAreAny) {
  Json scene = Json::parse(R"({
    "name": "cloth", "solver": {"type": "pbd", "dt": 0.01, "levels": 2, "levels_interval": 3}, "gravity": [0, -9.81, 0],
    "bodies": [{"name": "cloth", "mass": 1, "shape": {"grid": {"size": [1, 1], "cells": [40, 40]}},
                "pins": [{"row": "first"}], "constraints": [{"type": "distance", "elements": ["edges", "shear"]}]}],
    "duration": 0.02})");
  const Json with = report_of(scene, 2), levels = with["levels"];
  EXPECT_EQ(levels["every_substeps"], 3);
  ASSERT_EQ(levels["levels_fine_to_coarse"].size(), 2u);
  EXPECT_EQ(levels["levels_fine_to_coarse"][0]["particles"], 21 * 21) << "every second row and column of 41 x 41";
  EXPECT_EQ(levels["levels_fine_to_coarse"][1]["particles"], 11 * 11);
  for (const Json& level : levels["levels_fine_to_coarse"]) {
    EXPECT_GT(level["constraints"], level["particles"]) << "it hangs together in both directions";
    EXPECT_GE(level["patches"], 1);
  }
  const Json& each = with["timing"]["step_ms_by_level"];
  ASSERT_EQ(each.size(), 2u);
  for (const Json& level : each) EXPECT_GT(level, 0);
  EXPECT_LT(each[0].get<double>() + each[1].get<double>(), with["timing"]["step_ms_by_pass"]["fused_solve_ms"]);
  EXPECT_EQ(with["memory"]["levels_bytes"], levels["bytes"]);
  EXPECT_EQ(with["setup_s"]["levels"], levels["setup_s"]);
  EXPECT_GT(levels["setup_s"], 0);
  EXPECT_LT(levels["setup_s"], with["setup_s"]["total"]);
  Simulation simulation(parsed(scene), {.threads = 1});
  EXPECT_TRUE(has(summary(simulation), "\nlevels      2, of 441 particles and fewer, every 3 substeps\n"));

  scene["solver"]["levels"] = "off";
  const Json without = report_of(scene, 2);
  EXPECT_FALSE(without.contains("levels"));
  EXPECT_FALSE(without["memory"].contains("levels_bytes"));
  EXPECT_FALSE(without["setup_s"].contains("levels"));
  EXPECT_FALSE(without["timing"].contains("step_ms_by_level"));
  EXPECT_FALSE(has(summary(Simulation(parsed(scene), {.threads = 1})), "level"));
}

/// A sheet without constraints in free fall, dt = h: v = v0 + g t, and the steps' own sum x = x0 + v0 t + g t (t + h)
/// / 2. Its particles keep the angular momentum about their centre of mass that its spin w gave them, (3/8 + 3/8) m w
/// for the 25 of a square of 2 m.
TEST(Report, MeasuresMomentaAndEnergyOfFreeFall) {
  const Json report = report_of(Json::parse(R"({
    "name": "fall", "solver": {"type": "pbd", "dt": 0.01, "substeps": 1, "precision": "double"},
    "gravity": [0, -10, 0], "duration": 1,
    "bodies": [{"name": "sheet", "shape": {"grid": {"size": [2, 2], "cells": [4, 4]}}, "mass": 3,
                "transform": {"translate": [1, 20, -1]}, "velocity": [4, 0, 0], "spin": [0, 0.5, 0]}]})"),
                                50);
  const Json state = report["state"];
  const double m = 3, t = 0.5, h = 0.01, vx = 4, vy = -10 * t, w = 0.5;  // the centre starts at (2, 20, 0)
  const double y = 20 - 10 * t * (t + h) / 2, kinetic = m * (vx * vx + vy * vy) / 2 + 0.75 * m * w * w / 2;
  const double tolerance = 1e-10;  // of numbers up to 1e3 in double, after 50 steps of rounding
  const auto near = [tolerance](const Json& found, const std::vector<double>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_NEAR(found[k], expected[k], tolerance) << k;
  };
  EXPECT_NEAR(report["time_s"], t, 1e-14);
  EXPECT_EQ(report["step"], 50);
  near(state["momentum_kg_m_per_s"], {m * vx, m * vy, 0});
  near(state["angular_momentum_kg_m2_per_s"], {0, 0.75 * m * w, 0});
  EXPECT_NEAR(state["kinetic_energy_j"], kinetic, tolerance);
  EXPECT_NEAR(state["potential_energy_j"], m * 10 * y, tolerance);
  EXPECT_EQ(state["elastic_energy_j"], 0);
  EXPECT_NEAR(state["energy_j"], kinetic + m * 10 * y, tolerance);
  EXPECT_NEAR(state["speed_max_m_per_s"], std::hypot(vx + w, vy, w), tolerance);
  EXPECT_EQ(state["contacts"], 0);
  EXPECT_EQ(state["penetration_max_m"], 0);
}

TEST(Report, MeasuresStrainContactsAndVolume) {
  const Json state = report_of(everything(), 40)["state"];
  EXPECT_GT(state["strain_rms"], 0);
  EXPECT_LT(state["strain_rms"], state["strain_max"]);
  EXPECT_LT(state["strain_max"], 1);
  EXPECT_GT(state["elastic_energy_j"], 0);
  EXPECT_GE(state["contacts"], 1) << "the balloon lies on the ground";
  EXPECT_LE(state["contacts"], 162);
  EXPECT_GE(state["penetration_max_m"], 0);
  EXPECT_LE(state["penetration_max_m"], 0.01) << "of the thickness at most";
  ASSERT_EQ(state["volume_ratios"].size(), 1u);
  EXPECT_NEAR(state["volume_ratios"][0], 1.1, 0.05) << "the pressure asked for, but for the weight of the balloon";
}

/// 1e-18 m is far below the rounding a million metres away: both ends are the same point, and the edge has no
/// direction.
TEST(Report, CountsConstraintsWithoutADirection) {
  Json scene = Json::parse(R"({
    "name": "point", "solver": {"type": "pbd", "dt": 0.01}, "duration": 1,
    "bodies": [{"name": "chain", "mass": 1, "transform": {"translate": [1e6, 0, 0]},
                "shape": {"chain": {"from": [0, 0, 0], "to": [1e-18, 0, 0], "segments": 1}},
                "constraints": [{"type": "distance"}]}]})");
  EXPECT_EQ(report_of(scene, 1)["state"]["degenerate_constraints_skipped"], 1);
  scene["bodies"][0]["shape"]["chain"]["to"][0] = 1;
  EXPECT_EQ(report_of(scene, 1)["state"]["degenerate_constraints_skipped"], 0);
}

TEST(Report, HashesTheStateIntoSixteenDigits) {
  const std::string hash = report_of(everything(), 10)["state_hash"];
  EXPECT_EQ(hash.size(), 16u);
  EXPECT_EQ(hash.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_EQ(report_of(everything(), 10, {.threads = 2})["state_hash"], hash);
  EXPECT_NE(report_of(everything(), 11)["state_hash"], hash);
}

TEST(Report, KeepsTheWarnings) {
  Json json = everything();
  json["solver"]["precision"] = "float", json["bodies"][1]["transform"]["translate"] = {20000, 1, 0};  // too far for it
  const std::vector<std::string> said = warnings(Simulation(parsed(json)).model());
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(report_of(json, 1)["warnings"], Json(said));
}

TEST(Report, NamesEveryNumberWithItsUnitInSnakeCase) {
  Json report = report_of(everything(), 2);
  report.erase("notes"), report.erase("warnings");  // words, or empty lists
  report.erase("input");                            // the scene, in its own words
  const Json flat = report.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    EXPECT_EQ(pointer.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789/"), std::string::npos) << pointer;
    EXPECT_FALSE(value.is_null()) << pointer;
  }
}

}  // namespace
}  // namespace malha
