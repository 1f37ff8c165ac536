// SPDX-License-Identifier: Apache-2.0
// Long-range attachments of a model in the executor's memory (kernels/attachments/long_range.h).
#pragma once
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
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
    parallel_for(executor_, static_cast<int>(particle_.size()), LimitTethers<R>{tethers(w), p});
  }
  /// Largest relative excess of a particle over a tether; contacts may cause it.
  double beyond(const Points<R>& x, const R* w) const {
    return parallel_reduce<Largest>(executor_, static_cast<int>(particle_.size()),
                                    MeasureTetherExcess<R>{tethers(w), x})
        .value;
  }
  std::size_t bytes() const { return particle_.bytes() + begin_.bytes() + anchor_.bytes() + reach_.bytes(); }

 private:
  Tethers<R> tethers(const R* w) const { return {w, particle_.data(), begin_.data(), anchor_.data(), reach_.data()}; }

  Executor executor_;
  Array<Executor, int> particle_, begin_, anchor_;
  Array<Executor, R> reach_;
};

}  // namespace malha
