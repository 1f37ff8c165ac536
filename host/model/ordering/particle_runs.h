// SPDX-License-Identifier: Apache-2.0
// Ranges of particles of groups such as bodies, for sums over all groups in one launch.
#pragma once
#include <vector>

#include "kernels/measure/motion_energy.h"

namespace malha {

/// Ranges of consecutive particles of the same group. `group` is that of each particle; particles with a negative group
/// are in no range.
inline std::vector<ParticleRun> particle_runs(const std::vector<int>& group) {
  constexpr int kMaxParticles = 1024;  // large enough for few partial sums, small enough for many blocks in a launch
  std::vector<ParticleRun> runs;
  for (int i = 0; i < static_cast<int>(group.size()); ++i) {
    if (group[i] < 0) continue;
    const bool follows = !runs.empty() && runs.back().group == group[i] && runs.back().first + runs.back().count == i;
    if (!follows || runs.back().count == kMaxParticles) runs.push_back({i, 0, group[i]});
    ++runs.back().count;
  }
  return runs;
}

}  // namespace malha
