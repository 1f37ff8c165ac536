// SPDX-License-Identifier: Apache-2.0
// Quick version of the study "published": agreement with published results. Times are never asserted.
#include <cmath>
#include <map>

#include "tests/tools/study/quick_study.h"
#include "tools/study/published/published.h"

namespace malha::study {
namespace {

const Findings& quick_published() { return quick_findings<run_published>(); }

std::vector<Json> published_rows(const std::string& of) {
  std::vector<Json> rows;
  for (const Json& row : quick_published().rows)
    if (row["case"] == of) rows.push_back(row);
  return rows;
}

double published_number(const Json& row, const char* key) { return row[key].get<double>(); }

TEST(StudyPublished, SpringByXpbdHasThePeriodOfBackwardEulerForAnyIterations) {
  int found = 0;
  for (const Json& row : published_rows("spring of 2016")) {
    if (!row["what"].get<std::string>().starts_with("XPBD")) continue;
    ++found;
    // The tolerance is that of the fit to positions, which are accurate to 1e-16.
    EXPECT_NEAR(published_number(row, "period_s") / published_number(row, "backward_euler_period_s"), 1, 1e-6)
        << row["what"];
    // atan(a) / a = 1 - a^2 / 3 ..., a = omega h.
    const double a = std::sqrt(1000) / 60 / published_number(row, "substeps");
    EXPECT_NEAR(published_number(row, "period_s") / published_number(row, "exact_period_s"), 1 + a * a / 3,
                a * a * a * a / 10)
        << row["what"];
  }
  EXPECT_EQ(found, 4);
}

TEST(StudyPublished, SpringByPbdHasAPeriodThatFallsWithTheIterations) {
  std::vector<double> periods;
  for (const Json& row : published_rows("spring of 2016"))
    if (row["what"].get<std::string>().starts_with("PBD")) periods.push_back(published_number(row, "period_s"));
  ASSERT_EQ(periods.size(), 3u);
  EXPECT_GT(periods[0], 1.5 * periods[1]);
  EXPECT_GT(periods[1], 1.2 * periods[2]);
}

TEST(StudyPublished, ForceOfTheChainIsAsAccurateAsPrintedToAFactorOfThree) {
  const std::vector<Json> rows = published_rows("chain of 2016");
  ASSERT_EQ(rows.size(), 3u);
  double before = 1;
  for (const Json& row : rows) {
    EXPECT_LT(std::abs(std::log(published_number(row, "ours") / published_number(row, "printed"))), std::log(3))
        << row["iterations"];
    EXPECT_NEAR(published_number(row, "ours") / published_number(row, "plain_sweep"), 1, 0.1)
        << "the order of the sweep matters little";
    EXPECT_LT(published_number(row, "ours"), before);
    before = published_number(row, "ours");
  }
}

TEST(StudyPublished, WeightStretchesAChainAsInAPlainSweepAndAHundredTimesLessWithSubsteps) {
  std::map<std::string, double> most;
  for (const Json& row : published_rows("weight of 2019"))
    most[row["method"].get<std::string>() + " " + row["substeps"].dump() + " " + row["gravity_m_per_s2"].dump() + " " +
         row["dt_s"].dump()] = published_number(row, "most_m");
  EXPECT_NEAR(most.at("malha 1 10.0 0.03"), 322.1, 0.1) << "printed in the paper, with 100 iterations";
  EXPECT_NEAR(most.at("malha 100 10.0 0.03"), 3.2, 0.05) << "and with 100 substeps";
  for (const char* settings : {"1 10.0 0.03", "100 10.0 0.03"})
    EXPECT_NEAR(most.at(std::string("malha ") + settings) / most.at(std::string("plain sweep ") + settings), 1, 1e-4);
  EXPECT_LT(most.at("malha with long_range 10 10.0 0.03"), 0.02 * 0.19 * 1.05)
      << "the limit, a weight lowered by rounding";
}

TEST(StudyPublished, StrandIsShorterWithMoreSubstepsAtEqualWork) {
  std::vector<double> most;  // with 100 sweeps: 1 x 100, 10 x 10, 100 x 1
  double newton = 0;
  for (const Json& row : published_rows("strand of 2024")) {
    if (row["method"] == "Newton") newton = published_number(row, "most_m");
    if (row["method"] == "malha" && published_number(row, "substeps") * published_number(row, "iterations") == 100)
      most.push_back(published_number(row, "most_m"));
  }
  ASSERT_EQ(most.size(), 3u);
  EXPECT_GT(most[0], 5 * most[1]);
  EXPECT_GT(most[1], 5 * most[2]);
  EXPECT_GT(most[2], 5 * newton) << "none of them has converged";
}

TEST(StudyPublished, ClothOf1364VerticesDoesNotIntersectItself) {
  const std::vector<Json> rows = published_rows("cloth of 2006");
  ASSERT_FALSE(rows.empty());
  for (const Json& row : rows) {
    EXPECT_EQ(row["particles"], 1364);
    EXPECT_EQ(row["crossings"], 0);
  }
}

TEST(StudyPublished, HasSentencesAndATableForEachCase) {
  EXPECT_EQ(quick_published().sections.size(), 6u);
  for (const Section& section : quick_published().sections) {
    EXPECT_GE(section.sentences.size(), 2u) << section.title;
    EXPECT_FALSE(section.table.rows.empty()) << section.title;
  }
}

}  // namespace
}  // namespace malha::study
