// SPDX-License-Identifier: Apache-2.0
// Desbrun's filter of forces, dense or sparse, and how one of them is chosen.
#pragma once
#include <memory>

#include "host/base/progress.h"
#include "host/filter/system.h"
#include "host/measure/solver_stats.h"
#include "kernels/filter/filter_io.h"

namespace malha {

template <class R>
class Filter {
 public:
  virtual ~Filter() = default;
  /// Accelerations a = S F of the system's particles, from forces; others are left as they are. On free bodies the mean
  /// of a is undefined (S is kept without that mode, of which it would lose the digits of the others): take it from the
  /// sum of F.
  virtual void apply(const FilterIo<R>& io) const = 0;
  const FilterStats& facts() const { return facts_; }

 protected:
  FilterStats facts_;
};

/// Orders, factors, and keeps what the scene asks for; `auto` takes what is predicted to be faster on one thread, so
/// that the choice does not depend on the machine. Throws InputError where it would not fit into memory, naming what
/// would, and where the system is singular to working precision.
template <class Executor, class R>
std::unique_ptr<Filter<R>> make_filter(const Executor& executor, int threads, const Model& model,
                                       const SpringSystem& system, const ShowProgress& progress);

/// Measured now: some products.
template <class Executor, class R>
FilterErrors filter_errors(const Filter<R>& filter, const Model& model, const SpringSystem& system);

}  // namespace malha
