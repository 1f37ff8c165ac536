// SPDX-License-Identifier: Apache-2.0
// Memory layout of a model's constraints: patch by patch, and in a patch set by set and colour by colour.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "kernels/parallel/compute.h"
#include "kernels/projection/patch.h"

namespace malha {

/// The slots of one constraint set. Slots of runs have no index.
struct SetPlan {
  std::vector<int> constraint;                    // of each slot; -1: padding
  std::vector<LocalIndex> index[kMostParticles];  // in the patch's memory, of the particles of gathered slots
  int in_runs = 0;                                // constraints
  int most_batches = 0;                           // of a patch
};

struct PatchPlan {
  std::vector<Patch> patches;  // colour by colour
  std::vector<int> number;     // index of each patch in the model
  std::vector<int>
      colour_begin;  // first patch of each colour, and the number of patches; within a colour none is shared
  std::vector<Segment> segments;
  std::vector<Batch> batches;
  std::vector<SetPlan> sets;  // as in the model
  int most_slots = 0;         // of a patch, particles in fast memory
  int most_constraints = 0;   // of a patch, padding included
  int shared = 0;             // particles of more than one patch
  int columns = 0;            // patches that are laid out as a structure of arrays, for runs

  int colours() const { return static_cast<int>(colour_begin.size()) - 1; }
  /// Number of patches of the largest colour, the largest useful number of threads.
  int width() const;
  std::size_t bytes() const;  // of patches, segments and batches
};

/// One launch over the patches of a colour.
struct ColourSweep {
  int colour;
  Sweeps sweeps;
};

/// The launches of an iteration, in order (kernels/patch/solve_patch.h).
std::vector<ColourSweep> sweep_order(int colours);

/// The plan depends on the model alone, not on `threads`.
PatchPlan plan_patches(const Model& model, const OpenMP& threads = 1);

}  // namespace malha
