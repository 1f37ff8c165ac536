// SPDX-License-Identifier: Apache-2.0
// The numeric Cholesky factorisation of a spring system, in double.
#pragma once
#include <functional>

#include "host/base/progress.h"
#include "host/filter/supernodes.h"
#include "host/measure/solver_stats.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// Called with a supernode and its panel [L11^-1; -L21 L11^-1] by columns of height(s) numbers; from several threads.
using TakePanel = std::function<void(int supernode, const double* panel)>;

/// Multifrontal factorisation, in parallel over the tasks and then over the top. Returns -1, or the first column whose
/// pivot is only rounding errors: the system is then singular to working precision.
int factor(const SpringSystem& system, const Supernodes& all, const Subtrees& cut, const OpenMP& executor,
           const TakePanel& take, const ShowProgress& progress);

}  // namespace malha
