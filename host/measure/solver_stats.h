// SPDX-License-Identifier: Apache-2.0
// Statistics of a solver's set-up and steps, for reports and messages.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace malha {

/// Passes of a step, for timings. FusedSolve: prediction, projection and state update in one pass. Forces and Filter
/// are Desbrun's; MomentumCorrection is that of free bodies' momenta; Pins are kinematic pins.
enum class Pass {
  Pins,
  Damping,
  Air,
  Forces,
  Filter,
  MomentumCorrection,
  Prediction,
  Levels,
  Collision,
  Projection,
  Pressure,
  LongRange,
  Attachments,
  Contact,
  SelfCollision,
  State,
  FusedSolve,
  Tearing,
  Sleep,
  Edges,
  UserConstraints
};
inline constexpr std::array<const char*, 21> kPassNames{"pins",        "damping",     "air",
                                                        "forces",      "filter",      "momentum_correction",
                                                        "prediction",  "levels",      "collision",
                                                        "projection",  "pressure",    "long_range",
                                                        "attachments", "contact",     "self_collision",
                                                        "state",       "fused_solve", "tearing",
                                                        "sleep",       "edges",       "user_constraints"};

/// Statistics of a constraint set.
struct SetStats {
  std::string type;
  int constraints = 0;
  int in_runs = 0;       // constraints in runs, which load and store consecutive particles
  int most_batches = 0;  // largest number of batches (colours and runs) of a patch
  std::size_t bytes = 0;
};

struct PatchStats {
  int patches = 0;
  int colours = 0;               // patches of a colour are solved in parallel
  int columns = 0;               // patches laid out for runs
  int shared = 0;                // particles of more than one patch
  int most_slots = 0;            // particles of the largest patch in fast memory, padding included
  std::size_t memory_bytes = 0;  // fast memory of a patch solve
  std::size_t bytes = 0;
  double plan_seconds = 0;  // of set-up
};

/// Statistics of a level (host/model/levels.h).
struct LevelStats {
  int particles = 0, constraints = 0;
  PatchStats patches;
};

/// Statistics of the user's own constraints.
struct UserConstraintStats {
  std::string name;
  int constraints = 0, particles = 0, batches = 0;  // particles: of each constraint
};

struct ContactStats {
  long long closest_point_queries = 0;  // since the start, that the broad phase did not rule out
  long long full_queries = 0;  // of these, queries of all triangles of a mesh, by Embree; lists answer the others
  int near = 0;                // particles near a surface now, counted once for each mesh
  std::size_t near_bytes = 0, far_bytes = 0;  // of the contact cache: of near particles, and of all others
  std::size_t cell_bytes = 0;                 // of the meshes' lists of near triangles
};

/// An object of the environment that deforms.
struct DeformingStats {
  std::string name;
  int triangles = 0;
  std::size_t bytes = 0;
};

struct EdgeStats {
  int edges = 0, corners = 0;   // of the environment, that can touch
  std::int64_t candidates = 0;  // pairs that may come near in the next substeps, by the last broad phase
  std::int64_t pairs = 0;       // of these, pairs that may come near in this substep
  std::int64_t searches = 0;    // broad phases; there may be more than one in a substep
  // Substeps in which contacts were detected twice, because constraints moved particles farther than predicted.
  std::int64_t substeps_redetected = 0;
  std::int64_t substeps_truncated = 0;  // in which displacements were truncated, because primitives would intersect
  std::size_t bytes = 0;

  EdgeStats& operator+=(const EdgeStats& o) {
    edges += o.edges, corners += o.corners, candidates += o.candidates, pairs += o.pairs;
    searches += o.searches, substeps_redetected += o.substeps_redetected, substeps_truncated += o.substeps_truncated,
        bytes += o.bytes;
    return *this;
  }
};

/// Statistics of self-collision.
struct SelfStats {
  int particles = 0, edges = 0, triangles = 0;
  std::int64_t crossings = 0;           // at the start
  std::int64_t searches = 0;            // broad phases; there may be more than one in a substep
  std::int64_t substeps_truncated = 0;  // in which displacements were truncated, because primitives would intersect
  std::int64_t substeps_kinematic_penetration =
      0;                        // in which pins or objects may have gone through bodies that could not give way
  std::int64_t candidates = 0;  // pairs that the last broad phase tested
  std::int64_t pairs = 0;       // pairs that it found
  int colours = 0;              // patches of a colour share no particle
};

struct FilterStats {
  std::string kind;     // "dense" or "sparse"
  std::string storage;  // "float", "double" or "int16"
  std::string why;      // the scene's word, or the costs that were compared
  int unknowns = 0, bodies = 0;
  std::int64_t numbers = 0;  // stored, each read once (dense) or twice (sparse) a product
  std::size_t bytes = 0;
  int launches = 0;                                                  // of a product
  double order_seconds = 0, factor_seconds = 0, column_seconds = 0;  // of set-up; columns: of the dense S
};

/// Relative errors |S~ F - S F| / |S F|, over forces of independent random numbers and over elastic ones (A - M) d /
/// dt^2 of random displacements d, which S mostly cancels. S F is computed in double, to rounding, by iterative
/// refinement.
struct FilterErrors {
  double noise = 0, elastic = 0;
};
struct SolverStats {
  std::string instructions;  // of the kernels over packs
  PatchStats patches;
  std::vector<SetStats> sets;      // in the order of projection
  std::vector<LevelStats> levels;  // the finest first
  int levels_interval = 1;         // substeps
  std::size_t level_bytes = 0;
  int level_layouts = 0;                                 // one more for each set of pins that is released
  double level_seconds = 0;                              // of set-up
  std::optional<FilterStats> filter;                     // Desbrun's, or that of PBD's bending
  std::optional<SelfStats> self;                         // of self-collision
  std::optional<ContactStats> contact;                   // with the environment
  std::vector<DeformingStats> deforming;                 // its objects that deform
  std::optional<EdgeStats> edges;                        // with its edges and corners
  std::vector<UserConstraintStats> user_constraints;     // user constraints
  int free_bodies = 0;                                   // under Desbrun's method, with corrected momenta
  bool corrects = false;                                 // including angular momenta
  std::size_t spring_bytes = 0;                          // of their ends, stiffness and rest lengths
  std::size_t force_launches = 0;                        // of a sum of Desbrun's forces
  std::size_t bending_launches = 0;                      // of PBD's filtered bending in a substep
  std::size_t pressure_launches = 0;                     // of one projection of all pressures
  std::size_t pressure_starts = 0;                       // their launches at the start of a substep
  double colour_seconds = 0;                             // of set-up: colours of patches and of their constraints, runs
  double layout_seconds = 0;                             // particles and constraints laid out
  double constraint_seconds = 0, collision_seconds = 0;  // colours and layout of constraints; environment meshes
  std::size_t long_range_bytes = 0, air_bytes = 0;       // of attachments; of the faces in the air
  int long_range = 0, attachments = 0;                   // tethered particles, and their tethers in all
  int air_particles = 0;                                 // particles of faces in the wind
  std::size_t particle_bytes = 0, constraint_bytes = 0, collision_bytes = 0;
  // Projections of single constraints; batched ones count in both sweeps, pressure once per body, contacts not at all.
  std::int64_t projections_per_step = 0;
};

}  // namespace malha
