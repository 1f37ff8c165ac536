// SPDX-License-Identifier: Apache-2.0
#include "host/patch/solve_patches.h"

namespace malha {

template <class Executor, class AnySolve>
void solve_patches(const Executor& executor, const AnySolve& solve, int begin, int end, const ScratchMemory& memory) {
  parallel_groups(executor, begin, end, memory, solve);
}

template void solve_patches(const Serial&, const SolvePatch<float>&, int, int, const ScratchMemory&);
template void solve_patches(const Team&, const SolvePatch<float>&, int, int, const ScratchMemory&);
template void solve_patches(const Serial&, const SolveCoarsePatch<float>&, int, int, const ScratchMemory&);
template void solve_patches(const Team&, const SolveCoarsePatch<float>&, int, int, const ScratchMemory&);

}  // namespace malha
