// SPDX-License-Identifier: Apache-2.0
// The benchmark malha bench contact with small cases.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support.h"
#include "tools/bench/contact.h"

namespace malha {
namespace {

TEST(BenchContact, MeasuresTimeQueriesAndBytes) {
  const TemporaryFolder folder;
  bench::ContactOptions options;
  options.cases = {"ramp", "rotating_sphere"}, options.threads = {1, 2}, options.repeats = 1, options.seconds = 1e-3;
  options.out = (folder / "out").string(), options.scenes = MALHA_SOURCE_DIR "/scenes";
  bench::run_contact(options);
  const auto rows = nlohmann::json::parse(bytes_of(folder / "out" / "contact.json"));
  ASSERT_EQ(rows.size(), 4u);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto& row = rows[k];
    EXPECT_EQ(row["case"], k < 2 ? "ramp" : "rotating_sphere");
    EXPECT_GT(row["contact_ns_per_particle_and_substep"], 0);
    EXPECT_GT(row["floor_ns_per_particle_and_substep"], 0);
    EXPECT_GT(row["list_queries_per_step"], row["full_queries_per_step"].get<double>());
    // 24 and 400 bytes, and room in the lists for an eighth more, or for half more of those that have grown again.
    EXPECT_LE(row["bytes_per_far_particle"], 36);
    EXPECT_LE(row["bytes_per_near_particle"], 450);
    EXPECT_EQ(row["state_hash_after_warm_up"], rows[k / 2 * 2]["state_hash_after_warm_up"]);
  }
}

}  // namespace
}  // namespace malha
