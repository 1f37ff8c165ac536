// SPDX-License-Identifier: Apache-2.0
// Patches: ranges of the solver's order of particles, each small enough for the fast memory of a core and large enough
// to be worth a solve. The particles of a patch are sorted so that those that are read together are adjacent.
#pragma once
#include <cstdint>
#include <vector>

#include "host/mesh/compressed_lists.h"
#include "kernels/parallel/compute.h"
#include "malha/mesh.h"

namespace malha {

struct ConstraintSet;

/// Bounds of the size of patches. The defaults are for the cores of a CPU.
struct PatchBounds {
  int min_particles = 512;
  // Lower bound if there are enough patches for all threads: smaller patches fill fewer lanes.
  int preferred_particles = 1024;
  int max_particles = 8192;
  int max_cut_percent = 10;  // percentage of constraints that may cross patches
  int slots = 0;             // largest number of slots in the memory of a patch; 0: as many as a LocalIndex can number
};

struct Patches {
  std::vector<int> begin;  // first particle of each patch, then the number of particles
  // First particle of each island: no constraint connects two islands, and each is a connected component or several.
  // Consecutive loose particles are one island.
  std::vector<int> islands;
  std::vector<std::uint8_t> class_of;  // of each particle; the particles of a constraint differ in it, or have kNoClass
  PatchBounds bounds = {};             // bounds that the cut respects
  int count() const { return static_cast<int>(begin.size()) - 1; }
  int island_of(int particle) const;
};

inline constexpr std::uint8_t kNoClass = 255;

struct Cut {
  std::vector<int> order;  // old index of each particle; particles stay in their patch and next to their component
  Patches patches;         // in the new order
};

/// Cuts each island into patches where few constraints cross, as if it were alone, so that its order of projection does
/// not depend on others. Small islands share patches. Each patch is sorted by class if that makes most of its
/// constraints contiguous; otherwise particles that other patches use come first. `component` is the connected
/// component of each particle, ascending. `edges` are all edges of the meshes, including those between pinned
/// particles, so that a pinned row is sorted like the others. The result is the same for any number of threads.
Cut cut_into_patches(const std::vector<ConstraintSet>& sets, const std::vector<Edge>& edges,
                     const std::vector<int>& component, const OpenMP& threads = 1, const PatchBounds& bounds = {});

/// The patch that owns each constraint: the lowest patch of its particles, unless that has too many foreign particles
/// to number. `foreign` counts, for each patch, the particles of other patches that its constraints use; it is
/// increased.
std::vector<int> owners(const ConstraintSet& set, const std::vector<int>& patch_of, std::vector<int>& foreign);

/// The patch of each particle.
std::vector<int> patch_of_particles(const Patches& patches);

/// The constraints of each patch, in creation order.
using ByOwner = CompressedLists<int>;
ByOwner by_owner(const std::vector<int>& owner, int patches);

/// Layout of a patch's memory for particles sorted by class. Each class starts at a multiple of the pack size, with a
/// spare pack between classes, so that a pack that reads past its class does not read particles of another one.
struct ClassLayout {
  std::vector<int> slot;  // of each particle
  int slots = 0;          // number of slots in all
};
ClassLayout lay_out_classes(const std::vector<std::uint8_t>& class_of);

/// True if enough of a patch's constraints are contiguous to lay its memory out for runs.
bool should_use_runs(int contiguous, int constraints);

}  // namespace malha
