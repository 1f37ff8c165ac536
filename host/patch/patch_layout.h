// SPDX-License-Identifier: Apache-2.0
// Layout of one patch: its particles in fast memory, and its constraints in batches.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "host/patch/patch_plan.h"

namespace malha {

/// The colours in which a sweep over all patches solves shared particles for the first and the last time.
struct SharedColours {
  std::vector<int> first, last;  // of each particle; above and below every colour for those that are not shared
  std::vector<int> colour;       // of each patch
};

/// One patch, with slots and indices relative to its own.
struct PatchLayout {
  Patch patch{};
  std::vector<Segment> segments;
  std::vector<Batch> batches;
  std::vector<SetPlan> sets;
};

/// `owned`: for each set, the constraints of each patch. `neighbours`: the particles of other patches that those have.
PatchLayout lay_out_patch(const Model& model, const std::vector<ByOwner>& owned, const SharedColours& shared, int patch,
                          const std::vector<int>& neighbours);

}  // namespace malha
