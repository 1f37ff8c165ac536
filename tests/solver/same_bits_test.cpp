// SPDX-License-Identifier: Apache-2.0
// What every feature promises of its bits; the scenes stand beside the other tests of each feature.
#include "tests/same_bits.h"

namespace malha {
namespace {

TEST_P(SameBits, OnAnyNumberOfThreads) {
  const std::uint64_t serial = hash_after_all({.threads = 1, .backend = Backend::Serial});
  for (const int threads : {1, 2, 3}) EXPECT_EQ(hash_after_all({.threads = threads}), serial) << threads << " threads";
}

TEST_P(SameBits, WhenResumedOnOtherThreads) {
  const auto checkpoint = [&](int stop) { return folder_ / ("checkpoint" + std::to_string(stop)); };
  Simulation whole = simulation({.threads = 1});
  for (const int stop : GetParam().stops) run_to(whole, stop), whole.save_checkpoint(checkpoint(stop));
  run_to(whole, GetParam().steps);
  GetParam().has_feature(whole);
  for (const int stop : GetParam().stops) {
    Simulation resumed = simulation({.threads = 2});
    resumed.load_checkpoint(checkpoint(stop));
    run_to(resumed, GetParam().steps);
    EXPECT_EQ(resumed.state_hash(), whole.state_hash()) << "from step " << stop;
  }
}

/// The state holds all that later steps read. The last state is restored first, so
/// that what happened after an earlier one (a tear, a sleeping body) is undone.
TEST_P(SameBits, WhenAnEarlierStateIsRestored) {
  Simulation whole = simulation({.threads = 1});
  std::vector<std::string> states;
  for (const int stop : GetParam().stops) run_to(whole, stop), states.push_back(whole.save_state());
  run_to(whole, GetParam().steps);
  const std::string end = whole.save_state();
  for (auto state = states.rbegin(); state != states.rend(); ++state) {
    whole.restore_state(*state);
    run_to(whole, GetParam().steps);
    EXPECT_TRUE(whole.save_state() == end);
  }
}

}  // namespace
}  // namespace malha
