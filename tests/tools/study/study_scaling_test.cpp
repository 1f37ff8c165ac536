// SPDX-License-Identifier: Apache-2.0
// Quick version of the study "scaling": the same bits on all numbers of threads, and fits. Times are never asserted.
#include <cmath>
#include <map>
#include <set>

#include "tests/tools/study/quick_study.h"
#include "tools/study/scaling/cell.h"
#include "tools/study/scaling/scaling.h"
#include "tools/study/scaling/sections.h"

namespace malha::study {
namespace {

const Findings& quick_scaling() { return quick_findings<run_scaling>(); }

TEST(StudyScaling, FindsTheSameBitsOnEveryNumberOfThreads) {
  std::map<std::string, std::set<std::string>> hashes;
  std::map<std::string, int> lines;
  for (const Json& row : quick_scaling().rows)
    if (row["kind"] == "strong") {
      const std::string of = row["method"].get<std::string>() + " " + row["side"].dump();
      hashes[of].insert(row["hash"].get<std::string>()), ++lines[of];
    }
  EXPECT_EQ(hashes.size(), 5u);
  for (const auto& [of, all] : hashes) {
    EXPECT_EQ(all.size(), 1u) << of;
    EXPECT_EQ(lines[of], static_cast<int>(scaling_threads().size())) << of;
  }
}

TEST(ScalingThreads, ArePowersOfTwoAndAllCores) {
  EXPECT_EQ(scaling_threads(1), (std::vector{1, 2})) << "two share the core";
  EXPECT_EQ(scaling_threads(2), (std::vector{1, 2}));
  EXPECT_EQ(scaling_threads(3), (std::vector{1, 2, 3}));
  EXPECT_EQ(scaling_threads(12), (std::vector{1, 2, 4, 8, 12}));
  EXPECT_EQ(scaling_threads(64), (std::vector{1, 2, 4, 8, 16, 32, 64}));
}

TEST(StudyScaling, GrowsABodyWithTheThreadsInWeakScaling) {
  for (const Json& row : quick_scaling().rows) {
    if (row["kind"] != "weak") continue;
    const double each = row["particles"].get<double>() / row["threads"].get<double>();
    EXPECT_NEAR(each / 2500, 1, 0.02) << "sides are whole numbers";
  }
}

TEST(StudyScaling, HasEveryPassOfAStep) {
  for (const Json& row : quick_scaling().rows) {
    if (row["kind"] != "strong") continue;
    std::set<std::string> passes;
    for (const auto& [key, value] : row.items())
      if (key.ends_with("_ms") && key != "step_ms") passes.insert(key);
    if (row["method"] == "PBD, 10 substeps")
      EXPECT_EQ(passes, (std::set<std::string>{"fused_solve_ms"}));
    else
      EXPECT_EQ(passes, (std::set<std::string>{"filter_ms", "forces_ms", "prediction_ms", "state_ms"}));
  }
}

TEST(StudyScaling, RunsOnMoreThreadsThanCoresToo) {
  static const std::atomic<bool> no_stop{false};
  const TemporaryFolder folder;
  Cells cells(folder / "cells.jsonl", {}, true, no_stop);
  for (const ClothMethod& method : cloth_methods()) {
    const Json cell = scaling_cell(method, {{1, 50}, {3, 50}, {8, 50}}, cells);
    const Json rows = scaling_rows("strong", method, 50, cell);
    ASSERT_EQ(rows.size(), 3u);
    for (const Json& row : rows) {
      EXPECT_EQ(row["hash"], rows[0]["hash"]) << row["threads"];
      EXPECT_GT(row["times_as_fast"].get<double>(), 0);
    }
    EXPECT_EQ(scaling_sections(rows, "not pinned").front().table.rows[2][2], "8");
  }
}

TEST(SerialFraction, IsFoundFromTimesThatFollowAmdahl) {
  const std::vector<int> threads{1, 2, 4, 8, 64};
  for (const double share : {0.0, 0.1, 0.5, 1.0}) {
    std::vector<double> seconds;
    for (const int t : threads) seconds.push_back(3 * (share + (1 - share) / t));
    ASSERT_TRUE(serial_fraction(threads, seconds)) << share;
    EXPECT_NEAR(*serial_fraction(threads, seconds), share, 1e-14);
  }
}

TEST(SerialFraction, IsNotFittedIfThereIsNone) {
  EXPECT_FALSE(serial_fraction({1, 2}, {1, 0.4})) << "more than twice as fast on two threads";
  EXPECT_FALSE(serial_fraction({1, 2, 4, 8}, {8, 3.9, 1.9, 0.9}));
  EXPECT_FALSE(serial_fraction({1, 2, 4, 8}, {1, 1.1, 1.3, 2})) << "slower with every thread";
}

/// A cell with these seconds per step on 1, 2, 4 and 8 threads, the same in each turn.
Json cell_of_eight(const std::vector<double>& seconds) {
  Json cell{{"load_average", 0.5}, {"lines", Json::array()}};
  for (std::size_t k = 0; k < seconds.size(); ++k)
    cell["lines"].push_back({{"threads", 1 << k},
                             {"particles", 10000},
                             {"step_s", {seconds[k], seconds[k], seconds[k]}},
                             {"least_step_s", seconds[k] / 2},
                             {"passes_s", {{"fused_solve", seconds[k] / 4}}},
                             {"setup_s", 0.1},
                             {"hash", "a"},
                             {"patches", 12},
                             {"patch_colors", 2},
                             {"must_move_bytes", 1e6},
                             {"triad_gb_per_s", 20}});
  return cell;
}

const ClothMethod kPbdCloth = cloth_methods()[0];

TEST(ScalingRows, HaveTheSpeedUpOfEightThreads) {
  const Json rows = scaling_rows("strong", kPbdCloth, 100, cell_of_eight({0.8, 0.5, 0.35, 0.275}));
  ASSERT_EQ(rows.size(), 4u);
  const Json& eight = rows[3];
  EXPECT_EQ(eight["threads"], 8);
  EXPECT_NEAR(eight["step_ms"].get<double>(), 275, 1e-9);
  EXPECT_NEAR(eight["times_as_fast"].get<double>(), 0.8 / 0.275, 1e-12);
  EXPECT_NEAR(eight["undisturbed_times_as_fast"].get<double>(), 0.8 / 0.275, 1e-12);
  EXPECT_NEAR(eight["efficiency"].get<double>(), 0.1 / 0.275, 1e-12);
  EXPECT_NEAR(eight["fused_solve_times_as_fast"].get<double>(), 0.8 / 0.275, 1e-12);
  EXPECT_NEAR(eight["gb_per_s"].get<double>(), 1e6 / (0.275 / 4) / 1e9, 1e-12)
      << "in the pass that reads and writes them";
  EXPECT_NEAR(eight["imbalance_by_patches"].get<double>(), 8.0 / 6, 1e-12) << "six patches per colour";
  for (const Json& row : rows)
    EXPECT_NEAR(row["serial_share"].get<double>(), 0.25, 1e-12) << "0.2 s of 0.8 s are serial";
}

TEST(ScalingRows, OfADeviceHaveItsBandwidth) {
  Json cell = cell_of_eight({0.5});
  cell["device"] = "a device", cell["lines"][0]["triad_gb_per_s"] = 1e6 / (0.5 / 4) / 1e9 * 4;
  const Section section = scaling_on_device(scaling_rows("strong", kPbdCloth, 100, cell));
  ASSERT_EQ(section.table.rows.size(), 1u);
  EXPECT_EQ(section.table.rows[0].size(), section.table.columns.size());
  EXPECT_EQ(section.table.rows[0][7], "25 %") << "bandwidth over that of a copy";
  EXPECT_TRUE(section.sentences[0].starts_with("On a device.")) << section.sentences[0];
}

TEST(ScalingRows, OfABodyThatGrowsCompareEqualTimes) {
  const Json rows = scaling_rows("weak", kPbdCloth, 100, cell_of_eight({0.5, 0.5, 0.625, 1}));
  EXPECT_EQ(rows[1]["efficiency"], 1);
  EXPECT_EQ(rows[3]["efficiency"], 0.5);
  EXPECT_FALSE(rows[3].contains("serial_share"));
}

TEST(ScalingRows, HaveTheReasonWhyACellWasLeftOut) {
  const Json rows = scaling_rows("strong", kPbdCloth, 100, {{"left_out", "too large"}});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0]["left_out"], "too large");
}

TEST(ScalingSections, SayWhichSerialFractionsAreNotFitted) {
  Json rows = scaling_rows("strong", kPbdCloth, 100, cell_of_eight({0.8, 0.39, 0.19, 0.09}));
  for (const Json& row : rows) EXPECT_TRUE(row["serial_share"].is_null());
  for (const Json& row : scaling_rows("strong", kPbdCloth, 316, cell_of_eight({0.8, 0.5, 0.35, 0.275})))
    rows.push_back(row);
  const Section strong = scaling_sections(rows, "OMP_PROC_BIND=close, OMP_PLACES=cores").front();
  EXPECT_EQ(strong.table.columns[7], "serial fraction");
  EXPECT_EQ(strong.table.rows[3][7], "not fitted");
  EXPECT_EQ(strong.table.rows[7][7], "0.25");
  std::string summary;
  for (const std::string& sentence : strong.sentences) summary += sentence + "\n";
  EXPECT_TRUE(has(summary, "OMP_PROC_BIND=close, OMP_PLACES=cores")) << summary;
  EXPECT_TRUE(has(summary, "Times as fast on 8 threads as on one")) << summary;
  EXPECT_TRUE(has(summary, ": not fitted (PBD, 10 substeps, 10,000), 0.25 (PBD, 10 substeps, 10,000). Not fitted: "))
      << summary;
}

TEST(PatchImbalance, IsTheBusiestThreadOverTheMean) {
  EXPECT_DOUBLE_EQ(imbalance(8, 2, 2), 1);
  EXPECT_DOUBLE_EQ(imbalance(6, 2, 2), 4.0 / 3) << "two and one";
  EXPECT_DOUBLE_EQ(imbalance(2, 2, 64), 64) << "one patch per colour: one thread works";
  EXPECT_DOUBLE_EQ(imbalance(0, 0, 2), 1) << "no patches";
}

TEST(LaunchCosts, AreMeasuredOnEveryNumberOfThreads) {
  std::vector<int> threads;
  for (const Json& row : quick_scaling().rows)
    if (row["kind"] == "launch") {
      threads.push_back(row["threads"].get<int>());
      EXPECT_GT(row["fork_join_us"].get<double>(), 0);
    }
  EXPECT_EQ(threads, scaling_threads());
}

}  // namespace
}  // namespace malha::study
