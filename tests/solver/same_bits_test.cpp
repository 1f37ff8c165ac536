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
  std::vector<std::pair<std::uint64_t, int>> saved;  // hash and tears
  for (const int stop : GetParam().stops) {
    run_to(whole, stop), whole.save_checkpoint(checkpoint(stop));
    saved.emplace_back(whole.state_hash(), whole.tears());
  }
  run_to(whole, GetParam().steps);
  GetParam().has_feature(whole);
  auto expected = saved.begin();
  for (const int stop : GetParam().stops) {
    Simulation resumed = simulation({.threads = 2});
    resumed.load_checkpoint(checkpoint(stop));
    EXPECT_EQ(std::pair(resumed.state_hash(), resumed.tears()), *expected++) << "at step " << stop;
    run_to(resumed, GetParam().steps);
    EXPECT_EQ(resumed.state_hash(), whole.state_hash()) << "from step " << stop;
  }
}

/// The state holds all that later steps read, on any number of threads. The last state is restored first, so that what
/// happened after an earlier one (a tear, a sleeping body) is undone.
TEST_P(SameBits, WhenAnEarlierStateIsRestored) {
  Simulation whole = simulation({.threads = 1});
  std::vector<std::string> states;
  for (const int stop : GetParam().stops) run_to(whole, stop), states.push_back(whole.save_state());
  run_to(whole, GetParam().steps);
  const std::string end = whole.save_state();
  Simulation other = simulation({.threads = 2});
  for (auto state = states.rbegin(); state != states.rend(); ++state)
    for (Simulation* const restored : {&whole, &other}) {
      restored->restore_state(*state);
      run_to(*restored, GetParam().steps);
      EXPECT_TRUE(restored->save_state() == end);
    }
}

}  // namespace
}  // namespace malha
