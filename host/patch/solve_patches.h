// SPDX-License-Identifier: Apache-2.0
// The launches of SolvePatch: they hold every constraint's kernels, so that they are compiled in one place a precision.
#pragma once
#include "kernels/multilevel/solve_coarse_patch.h"
#include "kernels/patch/solve_patch.h"

namespace malha {

/// Visits the patches begin .. end - 1: by Serial or a Team, a SolvePatch or a SolveCoarsePatch of either precision.
template <class Executor, class AnySolve>
void solve_patches(const Executor& executor, const AnySolve& solve, int begin, int end, const ScratchMemory& memory);

}  // namespace malha
