// SPDX-License-Identifier: Apache-2.0
#include "host/fields/fields.h"
#include "host/patch/patch_plan.h"

namespace malha {

namespace {

/// Adds the lines of patch k, in its order.
void add_lines(const Model& model, const PatchPlan& plan, int k, Structure& to) {
  const Patch& patch = plan.patches[k];
  for (int b = 0; b < patch.batches; ++b) {
    const Batch& batch = plan.batches[patch.batch + b];
    const ConstraintSet& set = model.sets[batch.set];
    if (set.arity != 2) continue;
    for (int slot = batch.slot; slot < batch.slot + batch.count; ++slot) {
      const int c = plan.sets[batch.set].constraint[slot];
      if (c < 0) continue;
      const int* const ends = &set.particles[std::size_t(c) * 2];
      to.lines.push_back({model.user_index[ends[0]], model.user_index[ends[1]]});
      to.owner.push_back(k), to.batch.push_back(b);
    }
  }
}

}  // namespace

Structure structure(const Model& model, int threads) {
  Structure all;
  all.patch.assign(model.x.size(), -1), all.colour = all.patch;
  if (model.scene.solver.type == "desbrun" && model.sets.empty()) return all;  // springs are not projected
  const PatchPlan plan = plan_patches(model, threads);
  all.patches = static_cast<int>(plan.patches.size()), all.colours = plan.colours();
  for (int colour = 0; colour < all.colours; ++colour)
    for (int k = plan.colour_begin[colour]; k < plan.colour_begin[colour + 1]; ++k) {
      const auto begin = model.patches.begin.begin() + plan.number[k];
      for (int i = begin[0]; i < begin[1]; ++i)
        all.patch[model.user_index[i]] = k, all.colour[model.user_index[i]] = colour;
      all.batches = std::max(all.batches, plan.patches[k].batches);
      add_lines(model, plan, k, all);
    }
  return all;
}

}  // namespace malha
