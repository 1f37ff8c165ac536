// SPDX-License-Identifier: Apache-2.0
// The numeric Cholesky factorisation of a spring system, in double; and a filter made of it, for the columns of the
// dense S and for measuring errors.
#pragma once
#include <functional>

#include "host/base/progress.h"
#include "host/filter/sparse_filter.h"
#include "host/filter/supernodes.h"
#include "host/measure/solver_stats.h"
#include "kernels/parallel/compute.h"
#include "kernels/simd/vec.h"

namespace malha {

/// Called with a supernode and its panel [L11^-1; -L21 L11^-1] by columns of height(s) numbers; from several threads.
using TakePanel = std::function<void(int supernode, const double* panel)>;

/// Multifrontal factorisation, in parallel over the tasks and then over the top. Returns -1, or the first column whose
/// pivot is only rounding errors: the system is then singular to working precision.
int factor(const SpringSystem& system, const Supernodes& all, const Subtrees& cut, const OpenMP& executor,
           const TakePanel& take, const ShowProgress& progress);

/// Filters by unknown. Products run on one thread each, and in workspaces of their own on several at once.
struct ExactFactor {
  ExactFactor(const SpringSystem& whole, const OpenMP& executor);

  SpringSystem system;  // with its unknowns for particles
  Supernodes all;
  Subtrees cut;
  SparseFilter<Serial, double> filter;
  int singular;  // the unknown at which the system proved singular, and nothing else is then defined; -1: none
};

/// The factor of one body.
SpringSystem body_system(const SpringSystem& system, int body);

/// Four columns of S from `first` on, an entry of each in a Vec4, by unknown of the body; from several threads.
using TakeColumns = std::function<void(int first, const Vec4<double>* columns)>;

/// Computes the columns of the dense S of one body from its factor, four at a time. For a free one the result is S
/// without its mean mode, S - 1 1^T / mass. `progress`: reports the share of columns that are done.
void dense_columns(const ExactFactor& exact, const OpenMP& executor, const TakeColumns& take,
                   const ShowProgress& progress);

}  // namespace malha
