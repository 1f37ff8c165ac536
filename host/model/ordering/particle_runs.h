// SPDX-License-Identifier: Apache-2.0
// Particles of groups, in pieces whose sums one launch finds.
#pragma once
#include <vector>

#include "kernels/measure/motion_energy.h"

namespace malha {

/// Runs of consecutive particles of one group. `group`: of each particle; below 0: of none, in no run.
inline std::vector<ParticleRun> particle_runs(const std::vector<int>& group) {
  constexpr int kMost = 1024;  // particles: few sums, and those of many bodies in one launch
  std::vector<ParticleRun> runs;
  for (int i = 0; i < static_cast<int>(group.size()); ++i) {
    if (group[i] < 0) continue;
    const bool follows = !runs.empty() && runs.back().group == group[i] && runs.back().first + runs.back().count == i;
    if (!follows || runs.back().count == kMost) runs.push_back({i, 0, group[i]});
    ++runs.back().count;
  }
  return runs;
}

}  // namespace malha
