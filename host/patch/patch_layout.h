// SPDX-License-Identifier: Apache-2.0
// One patch of a plan: its particles in its own memory, and its constraints in batches.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "host/patch/patch_plan.h"

namespace malha {

/// When a sweep over all patches visits the particles that more than one patch visits, by phase.
struct Touches {
  std::vector<int> first, last;  // of each particle; above and below every phase for those that are not shared
  std::vector<int> phase;        // of each patch
};

/// With slots and indices counted from the start of the patch.
struct PatchLayout {
  Patch patch{};
  std::vector<Segment> segments;
  std::vector<Batch> batches;
  std::vector<SetPlan> sets;
};

/// `owned`: of each set, the constraints of each patch. `neighbours`: the particles of other patches that those touch.
PatchLayout lay_out_patch(const Model& model, const std::vector<ByOwner>& owned, const Touches& touches, int patch,
                          const std::vector<int>& neighbours);

}  // namespace malha
