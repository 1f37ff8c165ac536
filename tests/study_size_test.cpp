// Facts of the study "size" in its quick version: memory a particle. Never a time.
#include <map>

#include "tests/quick_study.h"
#include "tools/study/size.h"

namespace malha::study {
namespace {

const Findings& quick_size() { return quick_findings<run_size>(); }

std::map<int, Json> rows_by_size(const std::string& method) {
  std::map<int, Json> rows;
  for (const Json& row : quick_size().rows)
    if (row["method"] == method) rows[row["particles"].get<int>()] = row;
  return rows;
}

double bytes_a_particle(const Json& row, const char* owner = "bytes") {
  return row[owner].get<double>() / row["particles"].get<double>();
}

TEST(StudySize, PbdTakesAsMuchMemoryAParticleFrom10000On) {
  const auto rows = rows_by_size("PBD, 10 substeps");
  EXPECT_NEAR(bytes_a_particle(rows.at(20164)) / bytes_a_particle(rows.at(10000)), 1, 0.03)
      << "patches differ a little";
  EXPECT_NEAR(bytes_a_particle(rows.at(10000), "bytes_by_owner_particles"), 40, 0.5) << "README";
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
  EXPECT_LT(large, 1.5 * small) << "n log n: of ten times as many, log2(20164) / log2(2116) = 1.3";
}

TEST(StudySize, SaysTimeMemoryAndSetUpOfEverySizeThatFits) {
  ASSERT_EQ(quick_size().sections.size(), 3u);
  for (const Section& section : quick_size().sections) {
    EXPECT_EQ(section.table.rows.size(), quick_size().rows.size());
    ASSERT_TRUE(section.chart);
    EXPECT_EQ(section.chart->series.size(), 3u);
  }
}

}  // namespace
}  // namespace malha::study
