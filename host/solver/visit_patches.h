// The launches of Visit: they hold every constraint's kernels, so that they are compiled in one place.
#pragma once
#include "kernels/visit.h"

namespace malha {

/// Visits the patches begin .. end - 1.
template <class R>
void visit_patches(const Serial& executor, const Visit<R>& visit, int begin, int end, const FastMemory& memory);
template <class R>
void visit_patches(const Team& team, const Visit<R>& visit, int begin, int end, const FastMemory& memory);

}  // namespace malha
