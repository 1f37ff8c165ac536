// The launches of Visit: they hold every constraint's kernels, so that they are compiled in one place a precision.
#pragma once
#include "kernels/coarse_visit.h"
#include "kernels/visit.h"

namespace malha {

/// Visits the patches begin .. end - 1.
void visit_patches(const Serial& executor, const Visit<float>& visit, int begin, int end, const FastMemory& memory);
void visit_patches(const Team& team, const Visit<float>& visit, int begin, int end, const FastMemory& memory);
void visit_patches(const Serial& executor, const CoarseVisit<float>& visit, int begin, int end,
                   const FastMemory& memory);
void visit_patches(const Team& team, const CoarseVisit<float>& visit, int begin, int end, const FastMemory& memory);
void visit_patches(const Serial& executor, const Visit<double>& visit, int begin, int end, const FastMemory& memory);
void visit_patches(const Team& team, const Visit<double>& visit, int begin, int end, const FastMemory& memory);
void visit_patches(const Serial& executor, const CoarseVisit<double>& visit, int begin, int end,
                   const FastMemory& memory);
void visit_patches(const Team& team, const CoarseVisit<double>& visit, int begin, int end, const FastMemory& memory);

}  // namespace malha
