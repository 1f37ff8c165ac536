// SPDX-License-Identifier: Apache-2.0
// How the constraints of a model lie in memory: patch by patch, and in a patch set by set and colour by colour.
#pragma once
#include <vector>

#include "host/model/model.h"
#include "kernels/projection/patch.h"

namespace malha {

/// The slots of one constraint set. Those of a run have no index.
struct SetPlan {
  std::vector<int> constraint;                    // of each slot; -1: padding
  std::vector<LocalIndex> index[kMostParticles];  // in the patch's memory, of the particles of gathered slots
  int in_runs = 0;                                // constraints
  int most_batches = 0;                           // of a patch
};

struct PatchPlan {
  std::vector<Patch> patches;    // phase by phase
  std::vector<int> number;       // of each, among those of the model
  std::vector<int> phase_begin;  // patches of one phase share no particle; one more: the number of patches
  std::vector<Segment> segments;
  std::vector<Batch> batches;
  std::vector<SetPlan> sets;  // as in the model
  int most_slots = 0;         // of fast memory
  int most_constraints = 0;   // of a patch, with what pads them
  int shared = 0;             // particles that more than one patch visits
  int columns = 0;            // patches whose memory is laid out for runs

  int phases() const { return static_cast<int>(phase_begin.size()) - 1; }
  /// Patches of the largest phase: more threads than this find nothing to do.
  int width() const;
  std::size_t bytes() const;  // of patches, segments and batches
};

/// A visit to the patches of a phase: which ways it goes through their constraints.
struct PhaseSweep {
  int phase;
  bool forward, backward;
  int sweeps() const { return forward + backward; }
};

/// Those of an iteration, in their order (kernels/patch/solve_patch.h).
std::vector<PhaseSweep> sweep_order(int phases);

/// Depends on the model alone, not on `threads`.
PatchPlan plan_patches(const Model& model, int threads = 1);

}  // namespace malha
