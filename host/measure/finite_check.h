// SPDX-License-Identifier: Apache-2.0
// Which particle a substep leaves without a finite place.
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

  /// The new state at the end of a substep of h seconds, counted from 0. Nobody waits for it.
  template <class R>
  void update(const Executor& executor, const Particles<R>& all, double h, int substep) {
    parallel_reduce_into(executor, all.count, UpdateState<R>{all, R(h), R(1 / h)}, first_.data() + substep);
  }

  /// Of the substep, or the first of all of a step: the lowest number, if any is lost.
  std::optional<int> in(int substep) const { return number(first_.get(static_cast<std::size_t>(substep))); }
  std::optional<int> in_step() const {
    for (const FirstIndex& first : first_.download())
      if (const std::optional<int> lost = number(first)) return lost;
    return std::nullopt;
  }

 private:
  static std::optional<int> number(const FirstIndex& first) {
    return first.index == FirstIndex{}.index ? std::nullopt : std::optional(first.index);
  }
  Array<Executor, FirstIndex> first_;  // of each substep
};

}  // namespace malha
