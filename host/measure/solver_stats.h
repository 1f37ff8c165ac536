// SPDX-License-Identifier: Apache-2.0
// Statistics of a solver, for reports and messages: what was set up, and what happened since.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace malha {

/// The passes of a step, for timings. FusedSolve: prediction, projection and state in one, where nothing lies between.
/// Forces, filter and correction (of free bodies' momenta) are Desbrun's.
/// Pins are those that move. UserConstraints: constraints of the caller's own.
enum class Pass {
  Pins,
  Damping,
  Air,
  Forces,
  Filter,
  Correction,
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
inline constexpr std::array<const char*, 21> kPassNames{
    "pins",           "damping",   "air",         "forces",   "filter",     "correction",  "prediction",
    "levels",         "collision", "projection",  "pressure", "long_range", "attachments", "contact",
    "self_collision", "state",     "fused_solve", "tearing",  "sleep",      "edges",       "user_constraints"};

/// Statistics of a constraint set.
struct SetStats {
  std::string type;
  int constraints = 0;
  int in_runs = 0;       // read and written as whole vectors
  int most_batches = 0;  // of a patch: its colours and runs
  std::size_t bytes = 0;
};

struct PatchStats {
  int patches = 0;
  int phases = 0;                // patches of a phase are visited at once
  int columns = 0;               // patches laid out for runs
  int shared = 0;                // particles that more than one patch visits
  int most_slots = 0;            // of fast memory, in the largest patch: its particles and what pads them
  std::size_t memory_bytes = 0;  // of fast memory that a visit asks for
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
  long long looks = 0;                        // since the start, at particles that may have come near
  long long queries = 0;                      // of all triangles of a mesh among them, by Embree
  int near = 0;                               // particles near a surface now, once for each mesh
  std::size_t near_bytes = 0, far_bytes = 0;  // of what is remembered of them, and of all others
  std::size_t cell_bytes = 0;                 // of the meshes' lists of near triangles
};

struct EdgeStats {
  int edges = 0, corners = 0;   // of the environment, that can touch
  std::int64_t candidates = 0;  // pairs that may come near in the next substeps
  std::int64_t pairs = 0;       // that may in this one
  std::int64_t searches = 0;    // for pairs, at times more than one in a substep
  std::int64_t laid_again = 0;  // in which constraints pulled so far that pairs were looked at twice
  std::int64_t held = 0;        // in which something would have crossed
  std::size_t bytes = 0;

  EdgeStats& operator+=(const EdgeStats& o) {
    edges += o.edges, corners += o.corners, candidates += o.candidates, pairs += o.pairs;
    searches += o.searches, laid_again += o.laid_again, held += o.held, bytes += o.bytes;
    return *this;
  }
};

/// What a person may want to know.
struct SelfStats {
  int particles = 0, edges = 0, triangles = 0;
  std::int64_t crossings = 0;       // at the start
  std::int64_t searches = 0;        // for pairs, at times more than one in a substep
  std::int64_t held = 0;            // substeps in which something would have crossed
  std::int64_t driven_through = 0;  // substeps in which bodies could not get out of the way of pins or objects
  std::int64_t candidates = 0;      // that the last search looked at
  std::int64_t pairs = 0;           // and found
  int phases = 0;                   // patches of a phase share no particle
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
/// dt^2 of random displacements d, which S takes most of away. S F: in double, to rounding, by iterative refinement.
struct FilterErrors {
  double noise = 0, elastic = 0;
};
struct SolverStats {
  std::string instructions;  // of the kernels over packs
  PatchStats patches;
  bool fused = false;               // prediction and state happen in the visits to the patches
  bool whole_steps = false;         // all substeps of a step in one parallel region
  bool contact_free_steps = false;  // both, in steps in which nothing can come near the environment
  std::vector<SetStats> sets;       // in the order of projection
  std::vector<LevelStats> levels;   // the finest first
  int levels_interval = 1;          // substeps
  std::size_t level_bytes = 0;
  int level_layouts = 0;                                 // one more for each set of pins that lets go
  double level_seconds = 0;                              // of set-up
  std::optional<FilterStats> filter;                     // Desbrun's
  std::optional<SelfStats> self;                         // of self-collision
  std::optional<ContactStats> contact;                   // with the environment
  std::optional<EdgeStats> edges;                        // with its edges and corners
  std::vector<UserConstraintStats> user_constraints;     // constraints of the caller's own
  int free_bodies = 0;                                   // of Desbrun's, whose momentum is corrected
  bool corrects = false;                                 // their angular momentum too
  std::size_t spring_bytes = 0;                          // of their ends, stiffness and rest lengths
  std::size_t force_launches = 0;                        // of a sum of Desbrun's forces
  std::size_t pressure_launches = 0;                     // of one projection of all pressures
  std::size_t pressure_starts = 0;                       // launches of theirs where a substep begins
  double colour_seconds = 0;                             // of set-up: phases of patches, runs, colours
  double layout_seconds = 0;                             // particles and constraints laid out
  double constraint_seconds = 0, collision_seconds = 0;  // colours and layout of constraints; environment meshes
  std::size_t long_range_bytes = 0, air_bytes = 0;       // of attachments; of the faces in the air
  int long_range = 0, attachments = 0;                   // particles that hang on pins, and on how many in all
  int air_particles = 0;                                 // that have faces in the air
  std::size_t particle_bytes = 0, constraint_bytes = 0, collision_bytes = 0;
  // Single constraints, those of batches there and back; pressure counted once a body, contacts not.
  std::int64_t projections_per_step = 0;
};

}  // namespace malha
