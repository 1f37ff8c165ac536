// SPDX-License-Identifier: Apache-2.0
// Quick version of the study "size": memory per particle, and errors. Times are never asserted.
#include <cmath>
#include <map>

#include "tests/tools/study/quick_study.h"
#include "tools/study/reference/chain.h"
#include "tools/study/size/size.h"

namespace malha::study {
namespace {

const Findings& quick_size() { return quick_findings<run_size>(); }

std::map<int, Json> rows_by_size(const std::string& method) {
  std::map<int, Json> rows;
  for (const Json& row : quick_size().rows)
    if (row["method"] == method && !row.contains("measures")) rows[row["particles"].get<int>()] = row;
  return rows;
}

double bytes_a_particle(const Json& row, const char* owner = "bytes") {
  return row[owner].get<double>() / row["particles"].get<double>();
}

TEST(StudySize, PbdTakesAsMuchMemoryAParticleFrom10000On) {
  const auto rows = rows_by_size("PBD, 10 substeps");
  EXPECT_NEAR(bytes_a_particle(rows.at(20164)) / bytes_a_particle(rows.at(10000)), 1, 0.03)
      << "patches differ a little";
  EXPECT_NEAR(bytes_a_particle(rows.at(10000), "bytes_by_owner_particles"), 76, 0.5)
      << "x with its rounding remainder, v, displacement and w: 52; and places as the host reads them: 24";
}

TEST(StudySize, DenseFilterTakesHalfTheSquareOfItsUnknowns) {
  const auto rows = rows_by_size("Desbrun, dense");
  const double unknowns = 34 * 33;  // one row is pinned
  // Panels of four rows are padded up to the diagonal block of 16.
  EXPECT_NEAR(rows.at(34 * 34)["bytes_by_owner_filter"].get<double>() / (2 * unknowns * unknowns), 1, 0.1);
}

TEST(StudySize, SparseFilterGrowsALittleFasterThanItsUnknowns) {
  const auto rows = rows_by_size("Desbrun, sparse");
  const double small = bytes_a_particle(rows.at(2116), "bytes_by_owner_filter");
  const double large = bytes_a_particle(rows.at(20164), "bytes_by_owner_filter");
  EXPECT_GT(large, small);
  EXPECT_LT(large, 1.5 * small) << "n log n: with ten times as many, log2(20164) / log2(2116) = 1.3";
}

TEST(StudySize, HasTimeMemoryAndSetUpOfEverySizeThatFits) {
  ASSERT_EQ(quick_size().sections.size(), 7u);
  std::size_t costs = 0;
  for (const Json& row : quick_size().rows) costs += row.contains("measures") ? 0 : 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const Section& section = quick_size().sections[k];
    EXPECT_EQ(section.table.rows.size(), costs);
    ASSERT_TRUE(section.chart);
    EXPECT_EQ(section.chart->series.size(), 3u);
  }
}

/// The rows of a method on a mesh, by side.
std::map<int, Json> hanging_rows(const char* measures, const std::string& method, const std::string& mesh) {
  std::map<int, Json> rows;
  for (const Json& row : quick_size().rows)
    if (row.contains("measures") && row["measures"] == measures && row["method"] == method && row["mesh"] == mesh)
      rows[row["side"].get<int>()] = row;
  return rows;
}

TEST(StudySize, ShowsThatSweepsStretchWithTheSideAndLevelsDoNot) {
  for (const char* mesh : {"grid", "irregular"}) {
    const auto pbd = hanging_rows("error", "PBD", mesh), levels = hanging_rows("error", "levels", mesh);
    const auto grows = [](const std::map<int, Json>& rows) {
      return rows.at(80)["strain_rms"].get<double>() / rows.at(17)["strain_rms"].get<double>();
    };
    EXPECT_GT(levels.at(17)["levels"], 1);
    EXPECT_GT(levels.at(80)["levels"], 2);
    // The ratio of the sides is five.
    EXPECT_GT(grows(pbd), 4) << mesh;
    EXPECT_LT(grows(levels), 2.5) << mesh;
    EXPECT_LT(levels.at(80)["strain_rms"].get<double>(), pbd.at(80)["strain_rms"].get<double>()) << mesh;
    EXPECT_LT(levels.at(80)["error_m"].get<double>(), pbd.at(80)["error_m"].get<double>()) << mesh;
  }
}

TEST(StudySize, FindsTheWorkForAStrainOfAHundredth) {
  for (const char* method : {"PBD", "XPBD", "levels", "long_range"})
    for (const char* mesh : {"grid", "irregular"})
      for (const auto& [side, row] : hanging_rows("work", method, mesh)) {
        ASSERT_TRUE(row["left_out"].is_null()) << row;
        EXPECT_LE(row["strain_rms"].get<double>(), 0.01) << row;
      }
  const auto rows = hanging_rows("work", "PBD", "grid");
  EXPECT_GT(rows.at(33)["count"].get<int>(), rows.at(17)["count"].get<int>());
}

TEST(StudySize, ShowsThatFilteredBendingIsRightAtEveryResolution) {
  const auto error = [](const char* method, int along) {
    return hanging_rows("bending", method, "grid").at(along)["error_m"].get<double>();
  };
  for (const int along : {12, 36}) EXPECT_LT(error("filtered", along), 0.01) << along;
  EXPECT_LT(error("projected", 12), 0.02);
  EXPECT_GT(error("projected", 36), 0.2);
  EXPECT_GT(error("Desbrun", 36), 0.2) << "its springs hold the strip up";
  EXPECT_EQ(quick_size().sections.back().table.rows.size(), 6u);
  EXPECT_EQ(quick_size().sections.back().chart->series.size(), 3u);
}

/// A single link is a pendulum. Released from the horizontal, its speed at the bottom is sqrt(2 g l), which it reaches
/// after K(sin 45 deg) sqrt(l / g).
TEST(ReferenceChain, OfOneLinkIsAPendulum) {
  const double l = 2, g = 9.81, quarter = 1.8540746773013719 * std::sqrt(l / g);
  ReferenceChain chain(1, l, g);
  constexpr int steps = 20000;
  for (int k = 0; k < steps; ++k) chain.step(quarter / steps);
  // The leapfrog method is of second order in the step, and starts with a velocity half a step too early.
  EXPECT_NEAR(chain.joints()[1][0], -l, 1e-3);
  EXPECT_NEAR(chain.joints()[1][1], 0, 1e-3);
  EXPECT_NEAR(chain.kinetic(), 0.5 * g * l, 1e-3 * g * l);  // half of the link's mass of 1 kg is at its end
}

TEST(ReferenceChain, KeepsItsLengthAndItsEnergy) {
  const double l = 2, g = 9.81, h = 1e-4;
  ReferenceChain chain(40, l, g);
  double worst = 0, most = 0;
  for (int k = 0; k < 10000; ++k) {
    const double before = chain.potential();
    chain.step(h);
    // Total energy at the middle of a step, for 1 kg; it is 0 at the start.
    worst = std::max(worst, std::abs(chain.kinetic() + (before + chain.potential()) / 2));
    most = std::max(most, chain.kinetic());
  }
  EXPECT_LT(worst, 0.01 * most);  // the tip accelerates strongly after 0.8 s, within some ten steps
  for (std::size_t e = 0; e + 1 < chain.joints().size(); ++e)
    EXPECT_NEAR(
        std::hypot(chain.joints()[e + 1][0] - chain.joints()[e][0], chain.joints()[e + 1][1] - chain.joints()[e][1]),
        l / 40, 1e-10);
}

}  // namespace
}  // namespace malha::study
