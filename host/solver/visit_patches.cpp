#include "host/solver/visit_patches.h"

namespace malha {

template <class R>
void visit_patches(const Serial& executor, const Visit<R>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}
template <class R>
void visit_patches(const Team& team, const Visit<R>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(team, begin, end, memory, visit);
}

template void visit_patches(const Serial&, const Visit<float>&, int, int, const FastMemory&);
template void visit_patches(const Serial&, const Visit<double>&, int, int, const FastMemory&);
template void visit_patches(const Team&, const Visit<float>&, int, int, const FastMemory&);
template void visit_patches(const Team&, const Visit<double>&, int, int, const FastMemory&);

}  // namespace malha
