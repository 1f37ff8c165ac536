// SPDX-License-Identifier: Apache-2.0
// Launches of SolvePatch and SolveCoarsePatch. They instantiate the kernels of every constraint, and are therefore
// compiled once per precision.
#pragma once
#include "kernels/multilevel/solve_coarse_patch.h"
#include "kernels/patch/solve_patch.h"

namespace malha {

/// Solves the patches begin .. end - 1. Executor: Serial or a Team; AnySolve: SolvePatch or SolveCoarsePatch of either
/// precision.
template <class Executor, class AnySolve>
void solve_patches(const Executor& executor, const AnySolve& solve, int begin, int end, const ScratchMemory& memory);

}  // namespace malha
