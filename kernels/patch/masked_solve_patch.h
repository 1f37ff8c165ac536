// SPDX-License-Identifier: Apache-2.0
// Visits to some of the patches of a phase: while the host looks at particles of the others.
#pragma once
#include "kernels/environment/contact_cache.h"
#include "kernels/patch/solve_patch.h"

namespace malha {

/// Of a patch: whether it has a particle that is asked about.
struct MarkDeferredPatches {
  const Patch* patches;
  const Segment* segments;
  ActiveMask questions;
  bool* waits;
  KERNEL void operator()(int k) const {
    const Patch& patch = patches[k];
    bool any = false;
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s) {
      const int end = segments[s].global + segments[s].count;
      for (int i = segments[s].global; i < end && !any; i = (i / kGroupSize + 1) * kGroupSize) {
        const int last =
            end < (i / kGroupSize + 1) * kGroupSize ? end - 1 : i / kGroupSize * kGroupSize + kGroupSize - 1;
        const unsigned long long own = ~0ull >> (kGroupSize - 1 - (last - i)) << i % kGroupSize;
        any = questions.asked(i / kGroupSize) & own;
      }
    }
    waits[k] = any;
  }
};

/// Those that wait, or those that do not.
template <class R>
struct MaskedSolvePatch : SolvePatch<R> {
  const bool* waits;
  bool those;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    if (waits[group.index] == those) SolvePatch<R>::operator()(group);
  }
};

}  // namespace malha
