// SPDX-License-Identifier: Apache-2.0
// Patches: stretches of the solver's order, each small enough for a core's fast memory and large enough to be worth a
// visit. Their particles are sorted so that what is read together lies together.
#pragma once
#include <cstdint>
#include <vector>

#include "malha/mesh.h"

namespace malha {

struct ConstraintSet;

/// How large patches may be. The defaults are for the cores of a CPU.
struct PatchBounds {
  int min_particles = 512;  // particles: none is cut smaller,
  int preferred_particles =
      1024;  // nor than this, where there are enough for the threads: fewer constraints fill fewer lanes
  int max_particles = 8192;  // particles
  int max_cut_percent = 10;  // per cent of the constraints that may lead from patch to patch
  int slots = 0;             // of its memory; 0: as many as can be numbered
};

struct Patches {
  std::vector<int> begin;              // first particle of each patch, and one more: the number of particles
  std::vector<std::uint8_t> class_of;  // of each particle; those of one constraint have different ones, or kNoClass
  PatchBounds bounds = {};             // that they were cut by
  int count() const { return static_cast<int>(begin.size()) - 1; }
};

inline constexpr std::uint8_t kNoClass = 255;

struct Cut {
  std::vector<int> order;  // old index of each particle; particles stay in their patch and together with their island
  Patches patches;         // in the new order
};

/// Cuts where few constraints cross, and sorts each patch by class if that makes runs of most of its constraints,
/// otherwise those first that other patches touch too. `island`: of each particle, ascending. `edges`: of the meshes,
/// those between pinned particles too, so that a pinned row is sorted like the others. The same on any `threads`.
Cut cut_into_patches(const std::vector<ConstraintSet>& sets, const std::vector<Edge>& edges,
                     const std::vector<int>& island, int threads = 1, const PatchBounds& bounds = {});

/// The patch of each constraint: the lowest that one of its particles lies in (unless that has more neighbours already
/// than a patch can number).
std::vector<int> owners(const ConstraintSet& set, const std::vector<int>& patch_of, std::vector<int>& foreign);

/// The patch of each particle.
std::vector<int> patch_of_particles(const Patches& patches);

/// Lists of constraints by owner: those of patch k are list[begin[k]] .. list[begin[k + 1] - 1], in creation order.
struct ByOwner {
  std::vector<int> begin, list;
};
ByOwner by_owner(const std::vector<int>& owner, int patches);

/// Places in a patch's memory, and how many it takes, for its particles sorted by class: classes start with whole packs
/// and a spare one lies between them, so that a pack that reads past its class meets no particle of another one.
struct ClassLayout {
  std::vector<int> slot;
  int slots = 0;
};
ClassLayout lay_out_classes(const std::vector<std::uint8_t>& class_of);

/// Whether runs hold enough of a patch's constraints to lay its memory out for them.
bool worth_runs(int held, int constraints);

}  // namespace malha
