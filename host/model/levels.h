// SPDX-License-Identifier: Apache-2.0
// Multigrid levels: ever coarser versions of a model, on which large corrections propagate in a few sweeps (related to
// Müller 2008, Hierarchical Position Based Dynamics).
#pragma once
#include <vector>

#include "host/model/coarsening_graph.h"
#include "host/model/model.h"
#include "host/model/rest_graph.h"

namespace malha {

/// A coarse level. Its model has its own order of particles. The transfer weights number its particles by rank instead,
/// in the order of the finer particles that they stand for, so that neighbours there are neighbours here.
struct Level {
  Model model;                // its particles and coarse constraints only
  std::vector<int> particle;  // particle of the model for each rank
  Means restriction;          // for each rank a mean of finer particles, in the solver's order
  Means prolongation;         // for each finer particle a mean of ranks; empty if it is pinned or has no levels
};

/// Builds the levels, the finest first; empty if no body benefits. `w` are the present inverse masses (1/kg), 0 for
/// pinned particles.
std::vector<Level> make_levels(const Model& model, const std::vector<double>& w, const OpenMP& threads = 1);

/// Substeps from one use of the levels to the next: the setting of the scene, otherwise 2, or 1 with wind or moving
/// pins. Levels in every second substep correct the errors of two at once. That is right for a constant weight, but
/// makes bodies oscillate under wind or fast pins: a flag was faster than the storm.
int levels_interval(const Model& model);

/// The graph distance from the pins to the farthest particle from which on "auto" uses levels. Below it the sweeps of a
/// step alone are about as accurate (malha study accuracy, size).
std::int64_t auto_level_threshold(const SolverSpec& solver, bool elastic);

/// True if levels help this component. With "auto" it must be long, stiff within a substep, and hardly stretched by its
/// weight. Solids have no levels: coarse constraints that only pull let them sway, and those that also push make them
/// fold.
bool should_use_levels(const GraphComponent& part, const SolverSpec& solver);

}  // namespace malha
