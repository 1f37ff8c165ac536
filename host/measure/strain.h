// SPDX-License-Identifier: Apache-2.0
// The largest strains during a run.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace malha {

/// The `distance` constraints first .. first + count - 1 of a set of a model, or of its springs: those of one body.
struct LengthRun {
  int set;
  bool springs;
  int first, count, body;
};

/// The strains of the lengths of a state.
struct StrainSample {
  double largest = 0;       // |l - l0| / l0 of `distance` constraints
  int particle = -1;        // at an end of that one, by the user's number
  std::vector<double> rms;  // of each run of lengths
  double beyond = 0;        // the farthest beyond a reach of long-range attachments, over that reach
};

/// The largest strains of all samples.
struct LargestStrains {
  struct OfRun {
    double rms = 0;
    std::int64_t step = 0;
  };
  int every = 0;  // steps from sample to sample; 0: there is nothing to sample
  double largest = 0, beyond = 0;
  int particle = -1;
  std::int64_t step = 0, step_beyond = 0;
  std::vector<OfRun> runs;

  void take(const StrainSample& sample, std::int64_t now) {
    if (sample.largest > largest) largest = sample.largest, particle = sample.particle, step = now;
    if (sample.beyond > beyond) beyond = sample.beyond, step_beyond = now;
    runs.resize(std::max(runs.size(), sample.rms.size()));
    for (std::size_t s = 0; s < sample.rms.size(); ++s)
      if (sample.rms[s] > runs[s].rms) runs[s] = {sample.rms[s], now};
  }
};

}  // namespace malha
