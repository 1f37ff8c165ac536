// SPDX-License-Identifier: Apache-2.0
// A patch: constraints that are projected together on particles that fit in fast memory (a block of a domain
// decomposition). Every constraint belongs to one patch; particles at the boundary are shared, and patches that share
// one are never solved at once.
#pragma once
#include "kernels/simd/rows.h"

namespace malha {

/// The largest number of particles of a constraint that is projected in batches.
inline constexpr int kMostParticles = 6;

/// The largest number of particles of a patch, padding included: what a LocalIndex can address in every precision.
inline constexpr int kMostSlots = 65536 / kIndexScale<double>;

/// Batches begin at multiples of this many slots, the lanes of the widest pack, whatever the instruction set.
inline constexpr int kSlotPack = 16;

/// Particles that are consecutive both in the arrays and in the patch's memory, and that are treated alike.
struct Segment {
  int global, local, count;
  int origin, body;  // origin: particle of the same body in the patch that positions are relative to; connected body
  // Whether no other patch solves them before, or after, in a forward and backward sweep over all patches.
  bool first_solve, last_solve;
  bool movable;  // pinned particles are only read
};

/// Constraints of one set and one colour: no two share a movable particle.
/// In a run constraint i has the particles from[j] + i, for every i < count; gaps are padded. Particles of other
/// batches are gathered, and, unless there are pins, scattered in whole packs: padding then has particles of its own.
struct Batch {
  int set, slot, count;
  int first;  // number of slots of the patch's batches before it
  bool run, pins;
  LocalIndex from[kMostParticles];  // of a run
  int index;                        // of a gathered batch: offset of its particles in the set's index
  bool uniform_rest;                // a run whose rest values are all the same
  int common;                       // their offset in the set's `common`
  int rests;  // offset of the slots' rest values in the set's `rest`; of a uniform run: of its bits in `valid`
};

struct Patch {
  int segment, segments;
  int batch, batches;
  int slots;     // particles in fast memory, padding included
  bool columns;  // whether that memory is a structure of arrays (SoaView): kernels/projection/patch_memory.h
};

/// The sweeps over a patch's constraints that one solve does.
enum class Sweeps : unsigned char { Forward, Backward, Both };
KERNEL constexpr bool goes_forward(Sweeps sweeps) { return sweeps != Sweeps::Backward; }
KERNEL constexpr bool goes_backward(Sweeps sweeps) { return sweeps != Sweeps::Forward; }

template <class R>
struct SetView;

/// All patches of a model.
template <class R>
struct PatchData {
  const Patch* patches;
  const Segment* segments;
  const Batch* batches;
  const SetView<R>* sets;
  bool prefetches;  // the particles do not fit in a core's caches: those of the next patch are prefetched
};

/// Part of a kernel that a launch may have or not. (A device has no std::optional.)
template <class Part>
struct Optional {
  Part part{};
  bool given = false;
  Optional() = default;
  KERNEL Optional(const Part& of) : part(of), given(true) {}
  KERNEL explicit operator bool() const { return given; }
  KERNEL const Part* operator->() const { return &part; }
  KERNEL const Part& operator*() const { return part; }
};

}  // namespace malha
