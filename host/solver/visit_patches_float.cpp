#include "host/solver/visit_patches.h"

namespace malha {

void visit_patches(const Serial& executor, const Visit<float>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}
void visit_patches(const Team& team, const Visit<float>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(team, begin, end, memory, visit);
}
void visit_patches(const Serial& executor, const CoarseVisit<float>& visit, int begin, int end,
                   const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}
void visit_patches(const Team& team, const CoarseVisit<float>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(team, begin, end, memory, visit);
}

}  // namespace malha
