// SPDX-License-Identifier: Apache-2.0
// The benchmark malha bench self with small cases.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support.h"
#include "tools/bench/self/self.h"

namespace malha {
namespace {

TEST(BenchSelf, MeasuresContactsWithoutIntersections) {
  const TemporaryFolder folder;
  bench::SelfOptions options;
  options.n = {400}, options.threads = {1, 2}, options.repeats = 2, options.seconds = 1e-3;
  options.out = (folder / "out").string();
  bench::run_self(options);
  const auto rows = nlohmann::json::parse(bytes_of(folder / "out" / "self.json"));
  ASSERT_EQ(rows.size(), 2u);
  for (const auto& row : rows) {
    EXPECT_EQ(row["particles"], 400);
    EXPECT_GT(row["self_collision_ns_per_particle_and_substep"], 0);
    EXPECT_GT(row["step_ns_per_particle_and_substep"], row["self_collision_ns_per_particle_and_substep"]);
    EXPECT_GT(row["self_contacts_per_particle"], 0);
    EXPECT_EQ(row["max_intersections"], 0);
    EXPECT_EQ(row["state_hash"], rows[0]["state_hash"]);
  }
}

TEST(BenchSelf, RunsEveryMotionWithoutIntersections) {
  const TemporaryFolder folder;
  bench::SelfOptions options;
  options.cases = bench::self_case_names();
  options.n = {100}, options.threads = {1, 2}, options.repeats = 1, options.seconds = 1e-3;
  options.out = (folder / "out").string();
  bench::run_self(options);
  const auto rows = nlohmann::json::parse(bytes_of(folder / "out" / "self.json"));
  ASSERT_EQ(rows.size(), 2 * options.cases.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k]["case"], options.cases[k / 2]);
    EXPECT_EQ(rows[k]["max_intersections"], 0) << rows[k]["case"];
    EXPECT_EQ(rows[k]["state_hash"], rows[k / 2 * 2]["state_hash"]) << rows[k]["case"];
    EXPECT_GT(rows[k]["candidates_per_particle"], 0) << rows[k]["case"];
  }
}

}  // namespace
}  // namespace malha
