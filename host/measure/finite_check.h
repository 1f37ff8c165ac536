// SPDX-License-Identifier: Apache-2.0
// Check for positions that are not finite, with the state update of a substep.
#pragma once
#include <optional>
#include <vector>

#include "host/base/array.h"
#include "kernels/forces/integrate.h"

namespace malha {

template <class Executor>
class FiniteCheck {
 public:
  explicit FiniteCheck(int substeps) : first_(static_cast<std::size_t>(substeps), FirstIndex{}) {}

  /// Updates the state at the end of a substep of h seconds, counted from 0, without synchronisation.
  template <class R>
  void update(const Executor& executor, const Particles<R>& all, double h, int substep) {
    parallel_reduce_into(executor, all.count, UpdateState<R>{all, R(h), R(1 / h)}, first_.data() + substep);
  }

  /// The lowest index of a particle without finite position after a substep, or after the first such substep of a step.
  std::optional<int> in(int substep) const { return index_of(first_.get(static_cast<std::size_t>(substep))); }
  std::optional<int> in_step() const {
    for (const FirstIndex& first : first_.on_host(staging_))
      if (const std::optional<int> found = index_of(first)) return found;
    return std::nullopt;
  }

 private:
  static std::optional<int> index_of(const FirstIndex& first) {
    return first.index == FirstIndex{}.index ? std::nullopt : std::optional(first.index);
  }
  Array<Executor, FirstIndex> first_;        // of each substep
  mutable std::vector<FirstIndex> staging_;  // the same, of a device
};

}  // namespace malha
