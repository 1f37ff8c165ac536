// SPDX-License-Identifier: Apache-2.0
#include "host/patch/solve_patches.h"

namespace malha {

template <class Executor, class AnyVisit>
void visit_patches(const Executor& executor, const AnyVisit& visit, int begin, int end, const ScratchMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}

template void visit_patches(const Serial&, const SolvePatch<double>&, int, int, const ScratchMemory&);
template void visit_patches(const Team&, const SolvePatch<double>&, int, int, const ScratchMemory&);
template void visit_patches(const Serial&, const SolveCoarsePatch<double>&, int, int, const ScratchMemory&);
template void visit_patches(const Team&, const SolveCoarsePatch<double>&, int, int, const ScratchMemory&);

}  // namespace malha
