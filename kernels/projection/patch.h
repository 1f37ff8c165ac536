// SPDX-License-Identifier: Apache-2.0
// A patch: constraints that are projected together on particles that fit in fast memory. The constraints of a patch
// belong to it alone; particles at its rim are shared, and patches that share one are never visited at once.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// The most particles of a constraint that is projected in batches.
inline constexpr int kMostParticles = 6;

/// The most particles of a patch, with all that pads them: what a LocalIndex can number in every precision.
inline constexpr int kMostSlots = 65536 / kIndexScale<double>;

/// Slots begin at multiples of this, the most lanes of a pack, whatever the lanes.
inline constexpr int kSlotPack = 16;

/// Particles that lie side by side in the arrays and in the patch's memory, and that are treated alike.
struct Segment {
  int global, local, count;
  int origin, body;  // from which particle they are told, one of their body's in the patch; connected body
  bool first_solve,
      last_solve;  // in a sweep there and back over all patches, no other patch visits them before, or after
  bool movable;    // pinned particles are only read
};

/// Constraints of one set and one colour: no two share a movable particle.
/// A run: constraint i has the particles from[j] + i, for every i < count; gaps are padded. Otherwise they are
/// gathered, and where there are no pins, whole packs are written back: padding then has particles of its own.
struct Batch {
  int set, slot, count;
  int first;  // slots of the patch's batches before it
  bool run, pins;
  LocalIndex from[kMostParticles];  // of a run
  int index;                        // otherwise, where the particles of the slots stand in the set's index
  bool uniform_rest;                // a run whose rest values are all the same
  int common;                       // where those stand, in the set's `common`
  int rests;  // where those of the slots begin, in the set's; if they are alike, the bits that tell padding, in `held`
};

struct Patch {
  int segment, segments;
  int batch, batches;
  int slots;     // of fast memory, particles
  bool columns;  // how that memory is laid out
};

}  // namespace malha
