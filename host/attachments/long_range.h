// SPDX-License-Identifier: Apache-2.0
// The long-range attachments of a model in the executor's memory (kernels/attachments/long_range.h).
#pragma once
#include <vector>

#include "host/base/array.h"
#include "host/model/long_range.h"
#include "kernels/attachments/long_range.h"

namespace malha {

template <class Executor, class R>
class LongRange {
 public:
  LongRange(const Executor& executor, const LongRangeSet& set)
      : executor_(executor), particle_(set.particle), begin_(set.begin), anchor_(set.anchor) {
    reach_ = Array<Executor, R>(std::vector<R>(set.max_distance.begin(), set.max_distance.end()));
  }

  void project(const Displaced<R>& p, const R* w) const {
    parallel_for(executor_, static_cast<int>(particle_.size()), LimitReach<R>{reaches(w), p});
  }
  /// The farthest that a particle is beyond a reach, over that reach: what contacts took back.
  double beyond(const Points<R>& x, const R* w) const {
    return parallel_reduce<Largest>(executor_, static_cast<int>(particle_.size()), MeasureBeyondReach<R>{reaches(w), x})
        .value;
  }
  std::size_t bytes() const { return particle_.bytes() + begin_.bytes() + anchor_.bytes() + reach_.bytes(); }

 private:
  PinReaches<R> reaches(const R* w) const {
    return {w, particle_.data(), begin_.data(), anchor_.data(), reach_.data()};
  }

  Executor executor_;
  Array<Executor, int> particle_, begin_, anchor_;
  Array<Executor, R> reach_;
};

}  // namespace malha
