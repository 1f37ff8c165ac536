// SPDX-License-Identifier: Apache-2.0
// Desbrun's filter of forces, dense or sparse, and the choice between both.
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
  /// of a is undefined (S is stored without that mode, which would cost it the digits of the others): compute it from
  /// the sum of F.
  virtual void apply(const FilterIo<R>& io) const = 0;
  const FilterStats& facts() const { return facts_; }

 protected:
  FilterStats facts_;
};

/// Orders and factors the system, and stores the filter that the scene asks for; `auto` is the one that is predicted to
/// be faster on one thread, so that the choice does not depend on the machine. Throws InputError if it does not fit
/// into memory, naming what does, and if the system is singular to working precision.
template <class Executor, class R>
std::unique_ptr<Filter<R>> make_filter(const Executor& executor, int threads, const Model& model,
                                       const SpringSystem& system, const ShowProgress& progress);

/// Measures the errors by some products.
template <class Executor, class R>
FilterErrors filter_errors(const Filter<R>& filter, const Model& model, const SpringSystem& system);

}  // namespace malha
