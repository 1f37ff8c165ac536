// SPDX-License-Identifier: Apache-2.0
// Levels: coarser and coarser pictures of a model, over which large corrections travel in a few sweeps (a relative of
// Müller 2008, Hierarchical Position Based Dynamics).
#pragma once
#include <vector>

#include "host/model/coarsening_graph.h"
#include "host/model/model.h"
#include "host/model/rest_graph.h"

namespace malha {

/// A level has an order of its own, in which its model is. Means number its particles by rank, the order of their
/// places among the finer particles: what is next to each other there is so here.
struct Level {
  Model model;                // particles and coarse constraints alone
  std::vector<int> particle;  // of each rank
  Means up;                   // of each rank: finer particles, in the solver's order
  Means down;                 // of each finer particle: ranks; none where it is pinned or has no levels
};

/// Finest level first; empty if no body benefits. `w`: of each particle now, 1/kg, 0 where it is held.
std::vector<Level> make_levels(const Model& model, const std::vector<double>& w, int threads = 1);

/// Substeps from one use of the levels to the next: what the scene says, otherwise 2, or 1 where wind blows or pins
/// move. Levels in every second substep make up for two at once, which is right for a weight, but what is blown or
/// dragged hard is then thrown to and fro: a flag was faster than the storm.
int levels_interval(const Model& model);

/// Particles on the way from the farthest particle of a body to its pins, from which "auto" has levels: for fewer the
/// sweeps of a step alone are about as near to the truth (malha study accuracy, size).
std::int64_t auto_level_threshold(const SolverSpec& solver, bool elastic);

/// Whether levels help this part. "auto": one that is long, stiff within a substep, and hardly stretched by its weight.
/// Solids have none: a coarse constraint that only pulls lets them sway, and one that pushes as well folds.
bool should_use_levels(const LinkedPart& part, const SolverSpec& solver);

}  // namespace malha
