// Facts of the study "scaling" in its quick version: the same bits, sound fits. Never a time.
#include <cmath>
#include <map>
#include <set>

#include "tests/quick_study.h"
#include "tools/study/scaling.h"
#include "tools/study/scaling_cell.h"

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

TEST(StudyScaling, GoesFromOneThreadToAllCores) {
  const std::vector<int> threads = scaling_threads();
  ASSERT_GE(threads.size(), 2u);
  EXPECT_EQ(threads[0], 1);
  for (std::size_t k = 1; k < threads.size(); ++k) {
    EXPECT_GT(threads[k], threads[k - 1]);
    EXPECT_LE(threads[k], 2 * threads[k - 1]);
  }
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
      EXPECT_EQ(passes, (std::set<std::string>{"visits_ms"}));
    else
      EXPECT_EQ(passes, (std::set<std::string>{"filter_ms", "forces_ms", "prediction_ms", "state_ms"}));
  }
}

TEST(StudyScaling, RunsOnMoreThreadsThanCoresToo) {
  static const std::atomic<bool> no_stop{false};
  const TemporaryFolder folder;
  Cells cells(folder / "cells.jsonl", {}, true, no_stop);
  const Json cell = scaling_cell(cloth_methods()[0], {{1, 50}, {5, 50}}, cells);
  EXPECT_EQ(cell["lines"][0]["hash"], cell["lines"][1]["hash"]);
}

TEST(SerialShare, IsFoundFromTimesThatFollowAmdahl) {
  const std::vector<int> threads{1, 2, 4, 8, 64};
  for (const double share : {0.0, 0.1, 0.5, 1.0}) {
    std::vector<double> seconds;
    for (const int t : threads) seconds.push_back(3 * (share + (1 - share) / t));
    EXPECT_NEAR(serial_share(threads, seconds), share, 1e-14);
  }
  EXPECT_LT(serial_share({1, 2}, {1, 0.4}), 0) << "more than twice as fast on two threads";
}

TEST(PatchImbalance, IsTheBusiestThreadOverTheMean) {
  EXPECT_DOUBLE_EQ(imbalance(8, 2, 2), 1);
  EXPECT_DOUBLE_EQ(imbalance(6, 2, 2), 4.0 / 3) << "two and one";
  EXPECT_DOUBLE_EQ(imbalance(2, 2, 64), 64) << "one patch a phase: one thread works";
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
