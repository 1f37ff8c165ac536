#include "host/solver/visit_patches.h"

namespace malha {

void visit_patches(const Serial& executor, const Visit<double>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}
void visit_patches(const Team& team, const Visit<double>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(team, begin, end, memory, visit);
}
void visit_patches(const Serial& executor, const CoarseVisit<double>& visit, int begin, int end,
                   const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}
void visit_patches(const Team& team, const CoarseVisit<double>& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(team, begin, end, memory, visit);
}

}  // namespace malha
