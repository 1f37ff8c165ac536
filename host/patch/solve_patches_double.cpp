#include "host/patch/solve_patches.h"

namespace malha {

template <class Executor, class AnyVisit>
void visit_patches(const Executor& executor, const AnyVisit& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}

template void visit_patches(const Serial&, const Visit<double>&, int, int, const FastMemory&);
template void visit_patches(const Team&, const Visit<double>&, int, int, const FastMemory&);
template void visit_patches(const Serial&, const CoarseVisit<double>&, int, int, const FastMemory&);
template void visit_patches(const Team&, const CoarseVisit<double>&, int, int, const FastMemory&);

}  // namespace malha
