// SPDX-License-Identifier: Apache-2.0
// Quick version of the study "stability", on both sides of each boundary: known-bad settings fail as stated, default
// settings do not.
#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support.h"
#include "tools/study/reference/sweep.h"
#include "tools/study/stability/maps.h"
#include "tools/study/stability/stability.h"

namespace malha::study {
namespace {

struct QuickPart {
  Findings findings;
  int cells = 0, planned = 0;
};

/// The findings of a part of the study, which runs at most once in a process.
const QuickPart& quick_part(const std::string& name) {
  static const std::atomic<bool> no_stop{false};
  static std::map<std::string, QuickPart> found;
  const auto [at, fresh] = found.try_emplace(name);
  QuickPart& part = at->second;
  if (!fresh) return part;
  const auto& all = stability_parts();
  const auto of = std::find_if(all.begin(), all.end(), [&](const StabilityPart& one) { return one.name == name; });
  if (of == all.end()) throw std::runtime_error("there is no part " + name);
  const TemporaryFolder folder;
  Cells cells(folder / "cells.jsonl", {}, true, no_stop, [&part](const auto&...) { ++part.cells; });
  part.planned = of->quick_cells, part.findings.sections = of->run(cells, part.findings.rows);
  return part;
}

/// The rows of a panel of a map.
std::vector<Json> panel_rows(const std::string& map, const std::string& panel) {
  std::vector<Json> rows;
  for (const Json& row : quick_part(map).findings.rows)
    if (row["map"] == map && row["panel"] == panel) rows.push_back(row);
  if (rows.empty()) throw std::runtime_error("there is no " + map + ": " + panel);
  return rows;
}

std::string verdict_at(const std::string& map, const std::string& panel, double x, double y) {
  for (const Json& row : panel_rows(map, panel))
    if (row["x"] == x && row["y"] == y) return row["verdict"].get<std::string>();
  return "not tried";
}

/// y of a line at its last or first x; NaN if the run was no longer finite.
double line_end(const std::string& map, const std::string& line, bool last = true) {
  const std::vector<Json> rows = panel_rows(map, line);
  const Json& y = (last ? rows.back() : rows.front())["y"];
  return y.is_null() ? NAN : y.get<double>();
}

/// The largest y of a line over its smallest.
double spread(const std::string& map, const std::string& line) {
  double low = 1e300, high = 0;
  for (const Json& row : panel_rows(map, line)) {
    low = std::min(low, row["y"].get<double>());
    high = std::max(high, row["y"].get<double>());
  }
  return high / low;
}

constexpr const char* kHolds = "stable";
constexpr const char* kIsWrong = "bounded but wrong";

TEST(StudyStability, FindsTheLimitsOfExplicitStepsFromTheSpectrum) {
  for (const double stiffness : {1e3, 1e5}) {
    const auto system = spring_system(hanging_sheet(5, 1, 0.2, 1 / stiffness));
    const double omega = largest_frequency(*system, system->start.x);
    for (const auto& [panel, limit] : {std::pair{"symplectic Euler", 2.0}, {"RK4", 2.828}})
      for (const Json& row : panel_rows("steps", panel)) {
        if (row["x"] != stiffness) continue;
        // The bisection is accurate to 4 %, the sheet stretches in motion, and 400 steps are too few for slow growth.
        EXPECT_NEAR(row["stable_to"].get<double>() * omega, limit, 0.12 * limit) << panel << " " << stiffness;
        EXPECT_NEAR(row["fails_from"].get<double>() * omega, limit, 0.12 * limit) << panel << " " << stiffness;
      }
  }
}

TEST(StudyStability, FindsThatNoStepOrStiffnessMakesMalhasMethodsDivergeAtStiffnessOfSprings) {
  for (const char* panel : {"XPBD, 1 iteration", "XPBD, 10 iterations"})
    for (const Json& row : panel_rows("steps", panel)) EXPECT_NE(row["verdict"], "diverged") << row;
  for (const char* panel :
       {"Desbrun, sparse", "Desbrun, dense", "Desbrun, int16", "Desbrun, refine 8", "backward Euler"})
    for (const Json& row : panel_rows("steps", panel)) EXPECT_EQ(row["verdict"], kHolds) << row;
}

TEST(StudyStability, FindsThatOneIterationOfASpringIsTooFewAtLargeSteps) {
  EXPECT_EQ(verdict_at("steps", "XPBD, 1 iteration", 1e5, 0.1), kIsWrong);
  EXPECT_EQ(verdict_at("steps", "XPBD, 1 iteration", 1e5, 1e-2), kHolds);
  EXPECT_EQ(verdict_at("steps", "XPBD, 10 iterations", 1e5, 0.1), kHolds);
}

TEST(StudyStability, FindsThatASoftPbdStiffnessStretchesAtLargeStepsAlone) {
  EXPECT_EQ(verdict_at("steps", "PBD, 1 iteration", 0.01, 1e-2), kIsWrong);
  EXPECT_EQ(verdict_at("steps", "PBD, 1 iteration", 0.01, 0.1), kIsWrong) << "it falls without a gain of energy";
  EXPECT_EQ(verdict_at("steps", "PBD, 1 iteration", 0.01, 1e-3), kHolds);
  EXPECT_EQ(verdict_at("steps", "PBD, 1 iteration", 1, 1e-2), kHolds);
}

TEST(StudyStability, FindsThatHeavyWeightsNeedSubsteps) {
  EXPECT_EQ(verdict_at("masses", "PBD, double", 1e3, 16), kIsWrong);
  EXPECT_EQ(verdict_at("masses", "PBD, double", 1e3, 64), kHolds);
  EXPECT_EQ(verdict_at("masses", "PBD, double", 10, 16), kHolds);
  EXPECT_EQ(verdict_at("masses", "PBD, 10 substeps", 1e3, 4), kIsWrong);
  EXPECT_EQ(verdict_at("masses", "PBD, 10 substeps", 1e3, 16), kHolds);
  EXPECT_EQ(verdict_at("masses", "PBD, 10 substeps", 10, 1), kHolds) << "the default";
  EXPECT_EQ(verdict_at("masses", "PBD, double", 1e3, 1024), kHolds);
  EXPECT_EQ(verdict_at("masses", "PBD, float", 1e3, 1024), kHolds);
  EXPECT_EQ(verdict_at("masses", "XPBD, 1 % springs", 1e3, 16), kIsWrong);
  EXPECT_EQ(verdict_at("masses", "XPBD, 1 % springs", 1e3, 64), kHolds);
  for (const double ratio : {10.0, 1e3})
    EXPECT_EQ(verdict_at("masses", "Desbrun, 1 % springs", ratio, 1), kHolds) << ratio;
}

TEST(StudyStability, FindsThatFinerSheetsNeedMoreSubsteps) {
  for (const char* panel :
       {"PBD, held at one row", "PBD, two corners", "XPBD 10 kN/m, one row", "XPBD 10 kN/m, two corners"}) {
    EXPECT_EQ(verdict_at("resolution", panel, 33, 1), kIsWrong) << panel;
    EXPECT_EQ(verdict_at("resolution", panel, 33, 16), kHolds) << panel;
  }
  for (const double n : {9, 33})
    for (const double substeps : {1, 16})
      EXPECT_EQ(verdict_at("resolution", "Desbrun 10 kN/m, two corners", n, substeps), kHolds) << n;
}

/// Expects warnings in the panels of PBD and XPBD of a map for settings that fail, and none for settings with `many`
/// times the substeps or iterations of the boundary.
void expect_warned(const std::string& map, double many) {
  for (const Json& row : quick_part(map).findings.rows) {
    const std::string panel = row["panel"];
    const bool ours = panel.starts_with("PBD") || panel.starts_with("XPBD") || panel.starts_with("malha");
    if (row["map"] != map || !ours) continue;
    const bool counts = map != "steps" && !row["stable_to"].is_null();
    if (row["verdict"] != kHolds) {
      EXPECT_EQ(row["warned"], true) << row;
    } else if (counts && row["y"].get<double>() >= many * row["stable_to"].get<double>()) {
      EXPECT_EQ(row["warned"], false) << row;
    }
  }
}

TEST(StudyStability, FindsThatRunWarnsOfFailingSettingsOnly) {
  for (const char* map : {"steps", "masses", "resolution", "order"}) {
    expect_warned(map, 3);
    EXPECT_EQ(quick_part(map).cells, quick_part(map).planned) << map;
  }
}

TEST(StudyStability, FindsThatSweepsFromThePinsGainEnergyAndColoursDoNot) {
  for (const char* panel : {"plain, from the pins, float", "plain, from the pins, 10 kN/m"})
    for (const double substeps : {10, 40}) EXPECT_EQ(verdict_at("order", panel, 9, substeps), kHolds) << panel;
  EXPECT_NE(verdict_at("order", "plain, from the pins, float", 33, 40), kHolds);
  EXPECT_NE(verdict_at("order", "plain, from the pins, 10 kN/m", 33, 10), kHolds);
  for (const char* panel :
       {"plain, colours, double", "plain, colours, float", "malha, double", "malha, float", "malha, 10 kN/m"}) {
    EXPECT_EQ(verdict_at("order", panel, 33, 40), kHolds) << panel;
    for (const Json& row : panel_rows("order", panel)) EXPECT_LT(row["energy_gain"].get<double>(), 0.01) << row;
  }
}

TEST(StudyStability, FindsThatMotionGrowsWithOneWaySweepsButNotWithMalhas) {
  EXPECT_GT(line_end("amplification", "one way, in order", false), 5) << "a second, with 10 substeps";
  EXPECT_NEAR(line_end("amplification", "one way, in order") / line_end("amplification", "one way, in order", false),
              16, 1e-6)
      << "the same factor per substep for any number of substeps";
  for (const char* line : {"there and back, in order", "malha"})
    EXPECT_LE(line_end("amplification", line), 0.1) << line << ": drawn for no growth";
  int seen = 0;
  for (const Json& row : quick_part("amplification").findings.rows) {
    if (row["map"] != "growth") continue;
    ++seen;
    EXPECT_LT(row["y"].get<double>(), 0.5) << row;  // 1/s; the accuracy of a measurement over 3 s
  }
  EXPECT_EQ(seen, 7);
  EXPECT_EQ(quick_part("amplification").cells, quick_part("amplification").planned);
}

TEST(StudyStability, FindsThatAFreeBodyConservesEnergyAndMomenta) {
  for (const char* what : {"momentum", "angular momentum"}) {
    EXPECT_LT(line_end("minute", std::string("malha, double: ") + what), 1e-11) << what;
    EXPECT_LT(line_end("minute", std::string("malha, float: ") + what), 1e-4) << what;
  }
  EXPECT_GT(line_end("minute", "one way: angular momentum"), 1e-2);
  EXPECT_EQ(quick_part("minute").cells, quick_part("minute").planned);
}

/// The RMS strain of 100 x 100 particles pinned at two corners after 35 frames of 40 substeps; NaN if no longer finite.
double strain_swept(bool from_pins) {
  const Scene scene = corner_pinned_sheet(100, 2, 1, 1);
  const auto system = spring_system(scene);
  PlainSweep<float> sweep(*system, from_pins ? order_from_pins(*system) : order_by_colour(*system));
  for (int substep = 0; substep < 35 * 40; ++substep) sweep.substep(1.0 / 60 / 40);
  const Vector strain = system->strains(sweep.state().x);
  return strain.norm() / std::sqrt(double(strain.size()));
}

TEST(StudyStability, ShowsThatASweepFromThePinsDivergesWhereOneByColoursIsStable) {
#if !defined(NDEBUG)
  GTEST_SKIP() << "half a minute without optimisation";
#endif
  EXPECT_FALSE(strain_swept(true) < 1e11);
  EXPECT_LT(strain_swept(false), 0.05);
}

TEST(StudyStability, FindsThatPbdStiffnessDependsOnTheStepAndComplianceDoesNot) {
  EXPECT_GT(spread("stiffness", "PBD, stiffness 0.5, substeps"), 20);
  EXPECT_LT(spread("stiffness", "compliance, substeps"), 5) << "one sweep a frame is too few";
  for (const char* line : {"compliance, substeps", "compliance, iterations"})
    EXPECT_NEAR(line_end("stiffness", line), 0.05, 0.01) << line << ": still oscillating a little";
}

TEST(StudyStability, FindsThatMalhaFallsInFloatWhereAPlainSweepDoesNot) {
  EXPECT_GT(line_end("substeps", "plain sweep, v = (p - x) / h"), 0.2) << "1,024 substeps";
  EXPECT_LT(line_end("substeps", "malha"), 0.1);
  EXPECT_LT(line_end("substeps", "malha", false), 1e-4) << "one substep";
}

TEST(StudyStability, FindsThatFloatIsAsAccurateFarAwayAsAtTheOrigin) {
  EXPECT_LT(line_end("distance", "float"), 1e-5) << "10 km";
  EXPECT_LT(line_end("distance", "float", false), 1e-5) << "1 m";
  EXPECT_LT(line_end("distance", "double"), 1e-10);
}

TEST(StudyStability, FindsThatRandomAndCollapsedStartsUnfold) {
  for (const char* method : {"PBD", "XPBD, 1 kN/m", "Desbrun, 1 kN/m"})
    for (const Json& row : panel_rows("start", method)) EXPECT_LT(row["rms_strain"].get<double>(), 0.05) << row;
  for (const Json& row : panel_rows("start", "symplectic Euler, 1 kN/m")) {
    EXPECT_EQ(row["rms_strain"].is_null(), row["x_name"] == "one point") << "the spring has no direction " << row;
    if (row["rms_strain"].is_null()) continue;
    EXPECT_GT(row["rms_strain"].get<double>(), 0.1) << "it is undamped";
  }
}

TEST(StudyStability, FindsThatNothingTunnelsThroughThinSurfaces) {
  bool seen = false;
  for (const Json& row : quick_part("thickness").findings.rows) {
    if (row["map"] != "thickness") continue;
    seen = true;
    EXPECT_EQ(row["passed"], 0) << row;
    EXPECT_EQ(row["crossings"], 0) << row;
    EXPECT_GT(row["passed_unseen_percent"], 50) << row << ": with a discrete test";
  }
  EXPECT_TRUE(seen);
}

TEST(StudyStability, FindsThatStiffShellsGainNoEnergyOnImpact) {
  int seen = 0;
  for (const Json& row : quick_part("impact").findings.rows) {
    if (row["map"] != "impact") continue;
    ++seen;
    EXPECT_EQ(row["verdict"], kHolds) << row;
    EXPECT_LT(row["speed"].get<double>(), 3) << row << ": times the speed of a free fall";
    EXPECT_LT(row["strain"].get<double>(), 3) << row;
  }
  EXPECT_EQ(seen, 4);
}

TEST(StudyStability, FindsThatOnlyTheDefaultCorrectorConservesAngularMomentum) {
  EXPECT_LT(line_end("torque", "corrector inertia (default)"), 1e-10);
  EXPECT_GT(line_end("torque", "corrector off"), 0.5);
  EXPECT_FALSE(line_end("torque", "corrector paper") < 0.5) << "or it is no longer finite";
  EXPECT_LT(line_end("torque", "corrector off", false), 1e-3) << "k h^2 / m of 1e-4";
}

TEST(StudyStability, FindsThatRefinementAndSubstepsReduceTheDampingOfRotatingParts) {
  EXPECT_LT(line_end("turning", "refine 16", false), line_end("turning", "refine 0", false));
  EXPECT_LT(line_end("turning", "256 substeps", false), line_end("turning", "refine 0", false) / 5);
  // A free fall of a quarter of a second is 0.31 m: with one step a frame, stiff springs hardly let the chain rotate.
  EXPECT_GT(line_end("turning", "refine 0"), 0.2);
  EXPECT_LT(line_end("turning", "XPBD, 16 substeps"), 0.01);
}

TEST(StudyStability, FindsThatUnfilteredGravityStretchesSpringsNextToPins) {
  EXPECT_GT(line_end("weight", "filter_external_forces: false"), 1) << "g h^2 / l of 1.6";
  EXPECT_LT(line_end("weight", "filter_external_forces: false", false), 0.03) << "g h^2 / l of 0.01";
  EXPECT_LT(line_end("weight", "filter_external_forces: true (default)"), 1e-2);
}

TEST(StudyStability, NamesRemediesForEachKnownFailure) {
  for (const char* map :
       {"stiffness", "substeps", "distance", "start", "thickness", "impact", "torque", "turning", "weight"}) {
    EXPECT_EQ(quick_part(map).cells, quick_part(map).planned) << map << ": progress ends at 100 %";
    for (const Section& section : quick_part(map).findings.sections) {
      EXPECT_FALSE(section.table.rows.empty()) << map;
      EXPECT_TRUE(std::any_of(section.sentences.begin(), section.sentences.end(), [](const std::string& line) {
        return has(line, "Remedy: ") || has(line, "Remedies: ");
      })) << map;
    }
  }
}

}  // namespace
}  // namespace malha::study
