// SPDX-License-Identifier: Apache-2.0
// Quick version of the study "parsimony": launches and bytes. Times are never asserted.

#include "tests/tools/study/quick_study.h"
#include "tools/study/parsimony/parsimony.h"

namespace malha::study {
namespace {

const Findings& quick_parsimony() { return quick_findings<run_parsimony>(); }

Json parsimony_row(const std::string& feature) {
  for (const Json& row : quick_parsimony().rows)
    if (row["feature"] == feature) return row;
  throw std::runtime_error("there is no " + feature);
}

TEST(StudyParsimony, FindsThatABareClothOnlyLaunchesPatchSolves) {
  const Json row = parsimony_row("nothing");
  EXPECT_EQ(row["kernels"], "SolvePatch<float> 20") << "10 substeps, 2 colours";
  EXPECT_EQ(row["kernels_added"], "");
  EXPECT_EQ(row["added_bytes"], 0);
  for (const char* owner : {"air", "springs", "filter", "collision"})
    EXPECT_EQ(row[std::string(owner) + "_bytes"], 0) << owner;
}

TEST(StudyParsimony, FindsThatConstraintsOfPatchesAddBytesButNoLaunch) {
  for (const char* feature :
       {"distance on diagonals", "distance_limit", "bending", "isometric_bending", "neo_hookean"}) {
    EXPECT_EQ(parsimony_row(feature)["kernels_added"], "") << feature;
    EXPECT_GT(parsimony_row(feature)["constraints_bytes_added"], 0) << feature;
  }
}

TEST(StudyParsimony, FindsTheOwnersOfAddedBytes) {
  EXPECT_GT(parsimony_row("air on faces")["air_bytes_added"], 0);
  EXPECT_GT(parsimony_row("levels")["levels_bytes_added"], 0);
  EXPECT_GT(parsimony_row("environment (touched)")["collision_bytes_added"], 0);
  EXPECT_GT(parsimony_row("self-collision (flat)")["collision_bytes_added"], 0);
  EXPECT_GT(parsimony_row("pressure")["constraints_bytes_added"], 0);
  // Multipliers are stored between the two halves of a symmetric sweep.
  EXPECT_GT(parsimony_row("compliance")["constraints_bytes_added"], 0);
  EXPECT_EQ(parsimony_row("compliance")["constraints_bytes_added"], parsimony_row("compliance")["added_bytes"]);
  EXPECT_EQ(parsimony_row("compliance")["kernels_added"], "");
  for (const char* free : {"drag on particles", "sleep (awake)"})
    EXPECT_EQ(parsimony_row(free)["added_bytes"], 0) << free;
  // The contact cache depends on how many particles are near a surface, so its bytes differ from motion to motion.
  EXPECT_EQ(parsimony_row("friction")["kernels_added"], "");
}

TEST(StudyParsimony, FindsThatSleepAddsALaunchAwakeAndRemovesAllAsleep) {
  EXPECT_EQ(parsimony_row("sleep (awake)")["kernels_added"], "MeasureSpeed<float> 1");
  EXPECT_EQ(parsimony_row("sleep (asleep)")["launches_a_step"], 0);
}

TEST(StudyParsimony, NeverLosesALaunchOnTheLadder) {
  std::int64_t before = 0;
  for (const Json& row : quick_parsimony().rows) {
    if (row["kind"] != "ladder") continue;
    EXPECT_EQ(row["kernels_gone"], "") << row["feature"];
    EXPECT_GE(row["launches_a_step"], before) << row["feature"];
    before = row["launches_a_step"].get<std::int64_t>();
  }
}

TEST(StudyParsimony, DrawsTimeMemoryAndTheLadder) {
  std::set<std::string> charts;
  for (const Section& section : quick_parsimony().sections) {
    EXPECT_FALSE(section.sentences.empty()) << section.title;
    EXPECT_FALSE(section.table.rows.empty()) << section.title;
    if (section.chart) charts.insert(section.chart->name);
  }
  EXPECT_EQ(charts, (std::set<std::string>{"ladder", "memory", "time"}));
}

}  // namespace
}  // namespace malha::study
